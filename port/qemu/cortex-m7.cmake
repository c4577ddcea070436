# Cortex-M7: double-precision FPU, hard-float ABI.
set(target cortex-m7)
set(processor cortex-m7)
set(prefix arm-none-eabi-)
set(cpu "-mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16")
set(flash 0x00000000 0x400000)
set(ram 0x20000000 0x400000)
set(stack 16384)
include(${CMAKE_CURRENT_LIST_DIR}/picolibc.cmake)
