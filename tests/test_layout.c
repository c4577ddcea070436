/* layout: the list of structs that the library gives to bindings. The truth is the
 * compiler's: offsetof and sizeof of the headers as a caller sees them.
 * tests/checks/check_layout.py checks that the list names every field of the headers. */
#include <stddef.h>
#include <string.h>

#include "rc_layout.h"
#include "test_support.h"

#define STRUCT(type) {#type, 0, (int32_t)sizeof(type)},
#define FIELD(type, field) \
    {#type "." #field, (int32_t)offsetof(type, field), (int32_t)sizeof(((type *)0)->field)},
static const rigcal_layout_entry EXPECTED[] = {RC_LAYOUT(STRUCT, FIELD)};
enum { N_EXPECTED = sizeof EXPECTED / sizeof EXPECTED[0] };

/* The full names. The names of the entries are cut if they do not fit. */
#define STRUCT_NAME(type) #type,
#define FIELD_NAME(type, field) #type "." #field,
static const char *const NAMES[] = {RC_LAYOUT(STRUCT_NAME, FIELD_NAME)};

static int is_field(const char *name)
{
    return strchr(name, '.') != NULL;
}

/* Line `index`, whose name must end inside its array. */
static rigcal_layout_entry layout_line(int32_t index)
{
    rigcal_layout_entry entry;

    FILL(entry);
    ASSERT_STATUS(RIGCAL_OK, rigcal_layout(&entry, index));
    TEST_ASSERT_NOT_NULL(memchr(entry.name, '\0', sizeof entry.name));
    return entry;
}

static void test_every_line_is_the_compilers_in_the_order_of_the_list(void)
{
    TEST_ASSERT_EQUAL_INT32(N_EXPECTED, rigcal_layout_count());
    for (int32_t i = 0; i < N_EXPECTED; i++) {
        const rigcal_layout_entry line = layout_line(i);

        TEST_ASSERT_EQUAL_STRING(NAMES[i], line.name);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(EXPECTED[i].offset, line.offset, NAMES[i]);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(EXPECTED[i].size, line.size, NAMES[i]);
    }
}

static void test_no_line_is_there_twice(void)
{
    for (int32_t i = 0; i < rigcal_layout_count(); i++) {
        const rigcal_layout_entry line = layout_line(i);

        for (int32_t k = 0; k < i; k++) {
            const rigcal_layout_entry other = layout_line(k);

            TEST_ASSERT_NOT_EQUAL_MESSAGE(0, strcmp(line.name, other.name), line.name);
        }
    }
}

/* The end of the struct `owner`: its last field must leave less than the alignment. A
 * solver has no fields here. */
static void assert_ends(const rigcal_layout_entry *owner, int n_fields, int32_t end,
                        int32_t widest)
{
    TEST_ASSERT_EQUAL_INT32_MESSAGE(0, owner->offset, owner->name);
    TEST_ASSERT_TRUE_MESSAGE(owner->size > 0, owner->name);
    if (n_fields > 0) {
        TEST_ASSERT_TRUE_MESSAGE(end <= owner->size, owner->name);
        TEST_ASSERT_TRUE_MESSAGE(owner->size - end < widest, owner->name);
    }
}

/* A field that the list does not have leaves a gap, before a field or at the end of the
 * struct. No gap may be as large as the alignment. */
static void test_the_fields_follow_their_struct_in_order_without_overlap(void)
{
    const int32_t widest = (int32_t)(sizeof(void *) > 8 ? sizeof(void *) : (size_t)8);
    rigcal_layout_entry owner = layout_line(0);
    int32_t end = 0;
    int n_fields = 0;

    TEST_ASSERT_FALSE(is_field(owner.name));
    for (int32_t k = 1; k < rigcal_layout_count(); k++) {
        const rigcal_layout_entry line = layout_line(k);
        const size_t length = strlen(owner.name);

        if (!is_field(line.name)) {
            assert_ends(&owner, n_fields, end, widest);
            owner = line;
            end = n_fields = 0;
            continue;
        }
        TEST_ASSERT_EQUAL_STRING_LEN(owner.name, line.name, length);
        TEST_ASSERT_EQUAL_CHAR('.', line.name[length]);
        TEST_ASSERT_TRUE_MESSAGE(line.size > 0, line.name);
        TEST_ASSERT_TRUE_MESSAGE(line.offset >= end, line.name);
        TEST_ASSERT_TRUE_MESSAGE(line.offset - end < widest, line.name);
        end = line.offset + line.size;
        n_fields++;
    }
    assert_ends(&owner, n_fields, end, widest);
}

static void test_a_solver_is_told_by_its_size_alone(void)
{
    static const struct {
        const char *name;
        size_t size;
    } SOLVERS[] = {{"rigcal_pose_solver", sizeof(rigcal_pose_solver)},
                   {"rigcal_robust_solver", sizeof(rigcal_robust_solver)},
                   {"rigcal_rig_solver", sizeof(rigcal_rig_solver)},
                   {"rigcal_paper_solver", sizeof(rigcal_paper_solver)},
                   {"rigcal_neldermead", sizeof(rigcal_neldermead)}};

    for (size_t i = 0; i < sizeof SOLVERS / sizeof SOLVERS[0]; i++) {
        int lines = 0;

        for (int32_t k = 0; k < rigcal_layout_count(); k++) {
            const rigcal_layout_entry line = layout_line(k);

            if (strncmp(line.name, SOLVERS[i].name, strlen(SOLVERS[i].name)) == 0) {
                TEST_ASSERT_EQUAL_STRING(SOLVERS[i].name, line.name);
                TEST_ASSERT_EQUAL_INT32((int32_t)SOLVERS[i].size, line.size);
                lines++;
            }
        }
        TEST_ASSERT_EQUAL_INT_MESSAGE(1, lines, SOLVERS[i].name);
    }
}

static void test_a_line_that_is_not_there_is_refused_and_nothing_written(void)
{
    const int32_t count = rigcal_layout_count();
    const int32_t no_line[] = {-1, count, count + 1, INT32_MIN, INT32_MAX};
    rigcal_layout_entry entry;

    for (size_t i = 0; i < sizeof no_line / sizeof no_line[0]; i++) {
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, entry, rigcal_layout(&entry, no_line[i]));
    }
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_layout(NULL, 0));
}

TEST_MAIN()
{
    RUN_TEST(test_every_line_is_the_compilers_in_the_order_of_the_list);
    RUN_TEST(test_no_line_is_there_twice);
    RUN_TEST(test_the_fields_follow_their_struct_in_order_without_overlap);
    RUN_TEST(test_a_solver_is_told_by_its_size_alone);
    RUN_TEST(test_a_line_that_is_not_there_is_refused_and_nothing_written);
}
