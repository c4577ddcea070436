# The benches, of which ctest runs a short form. Included by tests/CMakeLists.txt, whose
# folders and variables hold.

# The figures of BENCHMARKS.md. The program prints how it was built, so that the figures can
# be made again. ctest only checks that it runs.
string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
get_directory_property(build_options COMPILE_OPTIONS)
set(build ${CMAKE_C_COMPILER_ID} ${CMAKE_C_COMPILER_VERSION} ${CMAKE_C_FLAGS}
    ${CMAKE_C_FLAGS_${build_type}} ${build_options})
if(gnu_like)
    list(APPEND build -ffp-contract=off)
endif()
string(REGEX REPLACE "[; ]+" " " build "${build}")

# bench(NAME LIBRARY ARGUMENTS...): bench/NAME.c, run by ctest with these arguments.
function(bench name library)
    add_executable(${name} bench/${name}.c)
    rigcal_own_code(${name})
    target_compile_definitions(${name} PRIVATE BENCH_BUILD="${build}")
    target_link_libraries(${name} PRIVATE ${library})
    add_test(NAME ${name} COMMAND ${name} ${ARGN})
    set_tests_properties(${name} PROPERTIES LABELS bench TIMEOUT ${limit})
endfunction()

file(GLOB sets CONFIGURE_DEPENDS
    ${PROJECT_SOURCE_DIR}/examples/data/*/reference_poses.csv
    ${CMAKE_CURRENT_SOURCE_DIR}/data/*/reference_poses.csv)
list(TRANSFORM sets REPLACE "(.*)/reference_poses.csv" "\"\\1\"")
list(JOIN sets "," sets)

set(examples ${PROJECT_SOURCE_DIR}/examples)
add_executable(bench_paper
    bench/bench_paper.c ${examples}/cli_input.c ${examples}/cli_names.c
    ${examples}/cli_csv.c ${examples}/cli_foreign.c ${examples}/cli_os.c)
rigcal_own_code(bench_paper)
target_include_directories(bench_paper PRIVATE ${examples})
target_compile_definitions(bench_paper PRIVATE
    BENCH_BUILD="${build}" BENCH_SETS=${sets})
target_link_libraries(bench_paper PRIVATE rigcal_test_support)
add_test(NAME bench_paper COMMAND bench_paper grid 5)
set_tests_properties(bench_paper PROPERTIES LABELS bench TIMEOUT ${limit})

# Scenes, and what the right answers are. bench/opencv.sh links them too.
add_library(rigcal_bench_support STATIC
    bench/bench_scenes.c bench/bench_starts.c bench/bench_minima.c
    bench/bench_solution.c)
rigcal_own_code(rigcal_bench_support)
target_include_directories(rigcal_bench_support PUBLIC bench)
target_link_libraries(rigcal_bench_support PUBLIC rigcal_test_support)

bench(bench_pose rigcal_bench_support minima 20)
if(UNIX)
    add_test(NAME bench_pose_compare COMMAND sh -c
        "'$<TARGET_FILE:bench_pose>' answers 3 | '$<TARGET_FILE:bench_pose>' compare 3")
    set_tests_properties(bench_pose_compare PROPERTIES
        LABELS bench TIMEOUT ${limit})
endif()

bench(bench_wide rigcal_bench_support check 25)

# What a solve costs. ctest checks that its scenes are solved.
bench(bench_cost rigcal_bench_support check)

# How the cost grows with the number of points.
bench(bench_growth rigcal_bench_support check)

bench(bench_choose rigcal_test_support 1)

# Which views of a rig are named as wrong.
bench(bench_judge rigcal_test_support 1)

# Whether points are as accurate as their sigmas say.
bench(bench_points rigcal_test_support check)

# How often a monitor raises a false alarm.
bench(bench_alarm rigcal_test_support check)

# How many true matches a band holds. Compares spans with every pixel.
add_executable(bench_match bench/bench_match.c)
rigcal_own_code(bench_match)
target_link_libraries(bench_match PRIVATE rigcal_test_support)
foreach(what "bands 20" "spans 12")
    string(REGEX REPLACE " .*" "" name ${what})
    separate_arguments(words UNIX_COMMAND ${what})
    add_test(NAME bench_match_${name} COMMAND bench_match ${words})
    set_tests_properties(bench_match_${name} PROPERTIES LABELS bench TIMEOUT ${limit})
endforeach()

# Whether real matches are in their bands.
add_executable(bench_bands
    bench/bench_bands.c ${examples}/cli_input.c ${examples}/cli_names.c
    ${examples}/cli_csv.c ${examples}/cli_foreign.c ${examples}/cli_os.c)
rigcal_own_code(bench_bands)
target_include_directories(bench_bands PRIVATE ${examples})
target_link_libraries(bench_bands PRIVATE ${library})
if(NOT MSVC)
    target_link_libraries(bench_bands PRIVATE m)
endif()
add_test(NAME bench_bands COMMAND bench_bands ${examples}/data/opencv_stereo
    ${examples}/data/myptv_stepped ${examples}/data/openptv_cavity)
set_tests_properties(bench_bands PROPERTIES LABELS bench TIMEOUT ${limit})

# Whether the covariances of a monitor are right, and which body it blames.
bench(bench_monitor rigcal_test_support check)

# Whether ellipsoids hold the truth if intrinsics are not exact.
bench(bench_consider rigcal_test_support check)

# Which fault of a rig as a whole is named.
bench(bench_faults rigcal_test_support check)

# Rigs whose cameras have clocks of their own.
bench(bench_clocks rigcal_test_support check)

# The scenes of the paper's experiments, which are for the library in double.
if(RIGCAL_REAL STREQUAL "double")
    add_executable(bench_paper_scenes bench/bench_paper_scenes.c
        ${examples}/paper/scene.c ${examples}/paper/solve.c)
    rigcal_own_code(bench_paper_scenes)
    target_include_directories(bench_paper_scenes PRIVATE ${examples}/paper)
    target_link_libraries(bench_paper_scenes PRIVATE rigcal_bench_support)
    add_test(NAME bench_paper_scenes COMMAND bench_paper_scenes 5)
    set_tests_properties(bench_paper_scenes PROPERTIES
        LABELS bench TIMEOUT ${limit})
endif()

# Comparison with OpenCV; bench/opencv.sh switches it on.
option(RIGCAL_BENCH_OPENCV "Build bench_opencv, which wants OpenCV" OFF)
if(RIGCAL_BENCH_OPENCV)
    enable_language(CXX)
    find_path(opencv_headers opencv2/calib3d.hpp PATH_SUFFIXES opencv4)
    add_executable(bench_opencv bench/bench_opencv.cpp)
    rigcal_own_code(bench_opencv)
    target_compile_features(bench_opencv PRIVATE cxx_std_17)
    target_include_directories(bench_opencv SYSTEM PRIVATE ${opencv_headers})
    target_compile_definitions(bench_opencv PRIVATE BENCH_BUILD="${build}")
    target_link_libraries(bench_opencv PRIVATE
        rigcal_bench_support opencv_calib3d opencv_core)
endif()

bench(bench_robust rigcal_bench_support wrong 10)
bench(bench_beside rigcal_bench_support 20 50 near 10)

# Adjusted rigs; bench/rig.sh links the first bench with Ceres, too.
add_library(rigcal_bench_rigs STATIC bench/bench_rigs.c)
rigcal_own_code(rigcal_bench_rigs)
target_include_directories(rigcal_bench_rigs PUBLIC bench)
target_link_libraries(rigcal_bench_rigs PUBLIC rigcal_test_support)

bench(bench_rig rigcal_bench_rigs check)

add_executable(bench_rig_statistics bench/bench_rig_statistics.c bench/bench_rig_cases.c)
rigcal_own_code(bench_rig_statistics)
target_compile_definitions(bench_rig_statistics PRIVATE BENCH_BUILD="${build}")
target_link_libraries(bench_rig_statistics PRIVATE rigcal_test_support)
add_test(NAME bench_rig_statistics COMMAND bench_rig_statistics check)
set_tests_properties(bench_rig_statistics PROPERTIES LABELS bench TIMEOUT ${limit})

add_executable(bench_rig_views bench/bench_rig_views.c)
rigcal_own_code(bench_rig_views)
target_link_libraries(bench_rig_views PRIVATE rigcal_test_support)

option(RIGCAL_BENCH_CERES "Build bench_ceres, which wants Ceres" OFF)
if(RIGCAL_BENCH_CERES)
    enable_language(CXX)
    find_package(Ceres REQUIRED)
    add_executable(bench_ceres bench/bench_ceres.cpp)
    rigcal_own_code(bench_ceres)
    target_compile_features(bench_ceres PRIVATE cxx_std_17)
    target_link_libraries(bench_ceres PRIVATE rigcal_bench_rigs Ceres::ceres)
endif()

# All benches, for bench/run.sh.
get_directory_property(targets BUILDSYSTEM_TARGETS)
list(FILTER targets INCLUDE REGEX "^bench_")
add_custom_target(benches DEPENDS ${targets})
