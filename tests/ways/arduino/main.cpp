// Runs a sketch for as many passes of its loop as any search can take.
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
