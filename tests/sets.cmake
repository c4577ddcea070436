# Which unit tests a build has: RIGCAL_TEST_SET. Included by tests/CMakeLists.txt, which
# has the list of all, RIGCAL_TESTS, and the regressions.
#
#   all      every test
#   target   those that a target may change though another of its kind passes: the layout
#            of types, the order of bytes, rounding, the C library's functions, deep stacks
#   large    target, and those that 32 KB of RAM are too little for
#   one one test: only the build is tested
#
# Every layer runs with soft float, with hard float, and on hosts:
#
#   soft float         cortex-m0: all that fit in its RAM; rv32imac: large, the others.
#                      Both libraries are built for size. Neither has what takes_long lists
#   hard float         cortex-m4f: all, and the regressions
#   others of a kind   cortex-m7, cortex-m7-double, cortex-m33, rv32imafc: target
#   big-endian         mips, mips-double: target. Only what reads bytes can differ
#   hosts              all, and the regressions; shared: one, as unit tests reach functions
#                      that it hides
#
# All tests of one of these targets: cmake --preset mips -DRIGCAL_TEST_SET=all
set(RIGCAL_TEST_SET all CACHE STRING "Which unit tests: all, target, large or one")
set_property(CACHE RIGCAL_TEST_SET PROPERTY STRINGS all target large one)

set(one about)

# Two rigs of 80 views take 128 KB. The rays of an image and all windows of an alarm take
# more than 256 KB. The arguments of all functions, with the stack, take more than 16 KB.
set(wants_256k cost judge cause outline spans spans_arcs match alarm border)
set(wants_32k hostile)

# With soft float these take half of the time of all tests.
set(takes_long paper cause judge)

set(target
    about layout bytes store store_rig   # types, bytes
    linalg rotation camera logs chance   # rounding, the C library
    pose adjust rig verdict)             # deep stacks, all layers below
set(large ${target} ${wants_32k} ${wants_256k})
list(REMOVE_ITEM large ${takes_long})

# Tests that a build cannot have, or that another build has.
set(left_out)
if(CMAKE_CROSSCOMPILING)
    list(APPEND left_out p3p_data judge_data) # read files
    list(APPEND left_out bounds)              # the counts are those of the host
    if(RIGCAL_BARE_RAM LESS 0x8000)
        list(APPEND left_out ${wants_32k})
    endif()
    if(CMAKE_SYSTEM_PROCESSOR STREQUAL "cortex-m0")
        list(APPEND left_out ${takes_long})
    endif()
    if(RIGCAL_BARE_RAM LESS 0x40000)
        list(APPEND left_out ${wants_256k})
    endif()
endif()
# A library for size lacks functions (RIGCAL_FOR_SPEED), among them all of roots.
string(TOUPPER "CMAKE_C_FLAGS_${CMAKE_BUILD_TYPE}" flags_of_type)
set(is_for_size OFF)
if("${CMAKE_C_FLAGS} ${${flags_of_type}}" MATCHES "-Os")
    set(is_for_size ON)
    list(APPEND left_out roots)
endif()
if(RIGCAL_CONFIG_FILE)
    list(APPEND left_out bounds small) # they have config headers of their own
endif()
if(RIGCAL_COVERAGE)
    list(APPEND left_out bounds small) # they compile sources again, and count nothing
endif()
if(RIGCAL_SANITIZE)
    list(APPEND left_out bounds)            # the counts are those of other builds
    if(RIGCAL_REAL STREQUAL "float")
        list(APPEND left_out small sources) # the build in double has both sanitizers
    endif()
endif()
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "mips" OR
   (CMAKE_CROSSCOMPILING AND RIGCAL_REAL STREQUAL "double"))
    list(APPEND left_out small) # what is left out is the same on the host and on the Cortex
                                # cores
endif()

foreach(set one target large)
    foreach(name IN LISTS ${set})
        if(NOT name IN_LIST RIGCAL_TESTS)
            message(FATAL_ERROR "tests/sets.cmake: ${set} names ${name}, which is no test.")
        endif()
    endforeach()
endforeach()
if(NOT RIGCAL_TEST_SET MATCHES "^(all|target|large|one)$")
    message(FATAL_ERROR "RIGCAL_TEST_SET is \"${RIGCAL_TEST_SET}\"; it must be all, target, "
            "large or one.")
endif()
file(GLOB regressions CONFIGURE_DEPENDS regression/*.c)
if(NOT RIGCAL_TEST_SET STREQUAL "all")
    set(RIGCAL_TESTS ${${RIGCAL_TEST_SET}})
endif()
if(NOT RIGCAL_TEST_SET STREQUAL "all" OR
   (CMAKE_CROSSCOMPILING AND NOT CMAKE_SYSTEM_PROCESSOR STREQUAL "cortex-m4"))
    set(regressions) # they test the arithmetic, not the target
endif()
list(REMOVE_ITEM RIGCAL_TESTS ${left_out} "") # CMake before 3.20 does not accept an empty
                                              # list
