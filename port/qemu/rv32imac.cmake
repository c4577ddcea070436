# RISC-V without an FPU, as in an ESP32-C3.
set(target rv32imac)
set(processor riscv32)
set(prefix riscv64-unknown-elf-)
set(cpu "-march=rv32imac -mabi=ilp32 -mcmodel=medany")
set(flash 0x80000000 0x400000)
set(ram 0x80400000 0x400000)
set(stack 16384)
include(${CMAKE_CURRENT_LIST_DIR}/picolibc.cmake)
