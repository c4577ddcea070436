# The part that the bare targets share: picolibc brings the start-up code and the
# linker script, semihosting brings printf, arguments and the exit status back.
# A target file sets
#
#   target     its name, for run.sh
#   processor  CMAKE_SYSTEM_PROCESSOR
#   prefix     of the compiler's name
#   cpu        compiler flags
#   flash, ram "start size" of each
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR ${processor})
set(CMAKE_C_COMPILER ${prefix}gcc)
# CMake's first test program cannot run anywhere.
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

separate_arguments(flash)
separate_arguments(ram)
list(GET flash 0 flash_at)
list(GET flash 1 flash_size)
list(GET ram 0 ram_at)
list(GET ram 1 ram_size)

set(CMAKE_C_FLAGS_INIT
    "${cpu} --specs=picolibc.specs -ffunction-sections -fdata-sections")
# Tests print doubles.
string(APPEND CMAKE_C_FLAGS_INIT " -DPICOLIBC_DOUBLE_PRINTF_SCANF")
string(CONCAT CMAKE_EXE_LINKER_FLAGS_INIT
    "--crt0=semihost --oslib=semihost -Wl,--gc-sections"
    " -Wl,--defsym=__flash=${flash_at} -Wl,--defsym=__flash_size=${flash_size}"
    " -Wl,--defsym=__ram=${ram_at} -Wl,--defsym=__ram_size=${ram_size}"
    " -Wl,--defsym=__stack_size=${stack}")
set(RIGCAL_BARE_RAM ${ram_size}) # for the tests
set(CMAKE_CROSSCOMPILING_EMULATOR
    sh ${CMAKE_CURRENT_LIST_DIR}/run.sh ${target})
