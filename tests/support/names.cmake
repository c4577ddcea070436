# Checks that test programs accept a test's name: `program -n part_of_name` runs the tests
# of that name, and fails when there is none.
#
#   cmake -D "programs=PROGRAM;..." -P names.cmake

# Runs `program` with the arguments that follow. Sets `status` and `said`, its output.
function(run program)
    execute_process(COMMAND ${program} ${ARGN} RESULT_VARIABLE status
                    OUTPUT_VARIABLE said ERROR_VARIABLE said)
    set(status "${status}" PARENT_SCOPE)
    set(said "${said}" PARENT_SCOPE)
endfunction()

function(fail program)
    message(FATAL_ERROR "${program} ${ARGN}: status ${status}, and it said:\n${said}")
endfunction()

if(NOT programs)
    message(FATAL_ERROR "names.cmake: no programs.")
endif()
foreach(program IN LISTS programs)
    run(${program} -n no_test_of_this_name)
    if(NOT status EQUAL 1 OR NOT said MATCHES "no test \"no_test_of_this_name\"")
        fail(${program} -n no_test_of_this_name)
    endif()

    run(${program} -l)
    if(NOT status EQUAL 0 OR NOT said MATCHES "^test_[a-z0-9_]+\n" OR said MATCHES ":PASS")
        fail(${program} -l)
    endif()

    # A name that is first asked for and then left out.
    string(REGEX REPLACE "\n.*" "" name "${said}")
    run(${program} -n ${name} -x ${name})
    if(NOT status EQUAL 1)
        fail(${program} -n ${name} -x ${name})
    endif()
endforeach()

# The tests of one program are fast enough to run: its last test, by a part of its name.
list(GET programs 0 program)
run(${program} -l)
string(REGEX MATCHALL "test_[a-z0-9_]+" names "${said}")
list(GET names -1 name)
string(REGEX REPLACE "^test_" "" part ${name})
run(${program} -n ${part})
if(NOT status EQUAL 0 OR NOT said MATCHES "${name}:PASS" OR
   NOT said MATCHES "\n1 Tests 0 Failures")
    fail(${program} -n ${part})
endif()
