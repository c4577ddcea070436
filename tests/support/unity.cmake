# Makes the target unity, from the first of
#
#   1. RIGCAL_UNITY_DIR, a folder with unity.c, unity.h, unity_internals.h
#   2. a copy from a Debian source package (get_unity.sh), kept for the user
#      so that every build after the first finds it
#   3. FetchContent of a pinned upstream release

set(RIGCAL_UNITY_DIR "" CACHE PATH
    "Folder with Unity's unity.c, unity.h and unity_internals.h")

set(unity_release v2.6.1)
set(unity_files unity.c unity.h unity_internals.h)

# Debian's copy, in the user's cache, or in the build folder if there is no cache.
function(unity_from_debian out)
    set(${out} "" PARENT_SCOPE)
    if(NOT CMAKE_HOST_UNIX)
        return()
    endif()
    set(places ${CMAKE_BINARY_DIR}/unity-2.5.1)
    if(NOT "$ENV{XDG_CACHE_HOME}" STREQUAL "")
        list(INSERT places 0 $ENV{XDG_CACHE_HOME}/rigcal/unity-2.5.1)
    elseif(NOT "$ENV{HOME}" STREQUAL "")
        list(INSERT places 0 $ENV{HOME}/.cache/rigcal/unity-2.5.1)
    endif()
    foreach(place IN LISTS places)
        execute_process(
            COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/support/get_unity.sh ${place}
            RESULT_VARIABLE failed ERROR_VARIABLE reason OUTPUT_QUIET)
        if(NOT failed)
            set(${out} ${place} PARENT_SCOPE)
            return()
        endif()
        string(STRIP "${reason}" reason)
        message(STATUS "Unity: ${reason}")
        if(NOT failed EQUAL 2)
            return()
        endif()
    endforeach()
endfunction()

if(RIGCAL_UNITY_DIR)
    foreach(file IN LISTS unity_files)
        if(NOT EXISTS ${RIGCAL_UNITY_DIR}/${file})
            message(FATAL_ERROR
                    "RIGCAL_UNITY_DIR: there is no ${RIGCAL_UNITY_DIR}/${file}.")
        endif()
    endforeach()
    set(unity_dir ${RIGCAL_UNITY_DIR})
    message(STATUS "Unity: taken from RIGCAL_UNITY_DIR, ${unity_dir}")
else()
    unity_from_debian(unity_dir)
    if(unity_dir)
        message(STATUS "Unity: 2.5.1 of Debian's source package ntpsec, "
                       "in ${unity_dir}")
    endif()
endif()

if(NOT unity_dir)
    message(STATUS "Unity: fetching the upstream release ${unity_release}")
    include(FetchContent)
    FetchContent_Declare(unity_upstream
        GIT_REPOSITORY https://github.com/ThrowTheSwitch/Unity.git
        GIT_TAG ${unity_release}
        GIT_SHALLOW ON
        SOURCE_SUBDIR src)
    # Only the sources are used: src/ has no CMakeLists.txt that could be added. Before
    # 3.18, which does not know SOURCE_SUBDIR, it is enough to populate.
    if(CMAKE_VERSION VERSION_LESS 3.18)
        FetchContent_Populate(unity_upstream)
    else()
        FetchContent_MakeAvailable(unity_upstream)
    endif()
    set(unity_dir ${unity_upstream_SOURCE_DIR}/src)
endif()

# This is not our code: it is compiled without our warnings, and its headers count as those
# of the system.
add_library(unity STATIC ${unity_dir}/unity.c)
set_target_properties(unity PROPERTIES C_STANDARD 99 C_EXTENSIONS OFF)
target_compile_definitions(unity PUBLIC
    UNITY_INCLUDE_DOUBLE UNITY_SUPPORT_64 UNITY_USE_COMMAND_LINE_ARGS)
target_include_directories(unity SYSTEM PUBLIC ${unity_dir})
