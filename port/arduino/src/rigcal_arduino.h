/* rigcal_arduino.h - the choices of rigcal_config.h for sketches. A sketch cannot pass
 * options to the compiler, so they stand in this file. */
#ifndef RIGCAL_ARDUINO_H
#define RIGCAL_ARDUINO_H

/* Few boards have a double-precision FPU. Set 0 for a board that has one. */
#ifndef RIGCAL_USE_FLOAT
#define RIGCAL_USE_FLOAT 1
#endif

#endif /* RIGCAL_ARDUINO_H */
