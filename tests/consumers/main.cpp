// The same from C++.
#include <cstdio>

#include "rigcal.h"

int main()
{
    const rigcal_real ypr[3] = {rigcal_real(0.1), rigcal_real(0.2), rigcal_real(0.3)};
    rigcal_real R[9];

    if (rigcal_version() < 100 ||
        rigcal_sizeof_real() != static_cast<int32_t>(sizeof(rigcal_real)) ||
        rigcal_rotation_from_yaw_pitch_roll(R, ypr) != RIGCAL_OK) {
        std::printf("C++: the library is not what its header says\n");
        return 1;
    }
    std::printf("rigcal from C++\n");
    return 0;
}
