# Cortex-M4F: single-precision FPU, hard-float ABI.
set(target cortex-m4f)
set(processor cortex-m4)
set(prefix arm-none-eabi-)
set(cpu "-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16")
set(flash 0x00000000 0x400000)
set(ram 0x20000000 0x400000)
set(stack 16384)
include(${CMAKE_CURRENT_LIST_DIR}/picolibc.cmake)
