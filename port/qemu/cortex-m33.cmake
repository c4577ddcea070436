# Cortex-M33: single-precision FPU, hard-float ABI.
set(target cortex-m33)
set(processor cortex-m33)
set(prefix arm-none-eabi-)
set(cpu "-mcpu=cortex-m33 -mthumb -mfloat-abi=hard -mfpu=fpv5-sp-d16")
set(flash 0x10000000 0x400000)
set(ram 0x38000000 0x200000)
set(stack 16384)
include(${CMAKE_CURRENT_LIST_DIR}/picolibc.cmake)
