// The part of an Arduino core that the example needs, on the host.
#ifndef ARDUINO_H
#define ARDUINO_H

#include <cstdio>

struct SerialPort {
    void begin(long)
    {
    }
    void print(double number, int digits)
    {
        std::printf("%.*f", digits, number);
    }
    void print(const char *text)
    {
        std::printf("%s", text);
    }
    void println(const char *text)
    {
        std::printf("%s\n", text);
    }
};
extern SerialPort Serial;

void setup();
void loop();

#endif
