// Runs a sketch for as many turns of its loop as any search takes.
#include "Arduino.h"

SerialPort Serial;

int main()
{
    setup();
    for (int i = 0; i < 3000; i++) {
        loop();
    }
    return 0;
}
