# Cortex-M0, no FPU: the micro:bit, 256 KB of flash and 16 KB of RAM.
set(target cortex-m0)
set(processor cortex-m0)
set(prefix arm-none-eabi-)
set(cpu "-mcpu=cortex-m0 -mthumb")
set(flash 0x00000000 0x40000)
set(ram 0x20000000 0x4000)
set(stack 4096)
include(${CMAKE_CURRENT_LIST_DIR}/picolibc.cmake)
