/* about: the version, and the statuses in words. */
#include <string.h>

#include "test_support.h"

/* ---- version and size of a real ------------------------------------------ */

static void test_the_version_of_the_library_is_that_of_the_header(void)
{
    TEST_ASSERT_EQUAL_INT32(RIGCAL_VERSION_MAJOR * 10000 + RIGCAL_VERSION_MINOR * 100 +
                                RIGCAL_VERSION_PATCH,
                            rigcal_version());
}

static void test_the_library_and_its_caller_agree_on_the_size_of_a_real(void)
{
    TEST_ASSERT_EQUAL_INT32((int32_t)sizeof(rigcal_real), rigcal_sizeof_real());
    TEST_ASSERT_EQUAL_INT32(RIGCAL_USE_FLOAT ? 4 : 8, rigcal_sizeof_real());
}

/* ---- statuses ------------------------------------------------------------ */

typedef struct {
    rigcal_status status;
    const char *name;
} status_name;

#define STATUS(name, number, text) {number, #name},
static const status_name STATUSES[] = {RIGCAL_STATUSES(STATUS)};
enum { N_STATUSES = sizeof STATUSES / sizeof STATUSES[0] };

static int is_status(rigcal_status status)
{
    for (int i = 0; i < N_STATUSES; i++) {
        if (STATUSES[i].status == status) {
            return 1;
        }
    }
    return 0;
}

/* Numbers that callers have stored must not change: a few of them, from each end. */
static void test_the_numbers_of_statuses_do_not_change(void)
{
    TEST_ASSERT_EQUAL_INT32(0, RIGCAL_OK);
    TEST_ASSERT_EQUAL_INT32(1, RIGCAL_RUNNING);
    TEST_ASSERT_EQUAL_INT32(2, RIGCAL_BUDGET_SPENT);
    TEST_ASSERT_EQUAL_INT32(4, RIGCAL_AMBIGUOUS);
    TEST_ASSERT_EQUAL_INT32(9, RIGCAL_MOST_DISAGREE);
    TEST_ASSERT_EQUAL_INT32(-1, RIGCAL_ERR_NULL);
    TEST_ASSERT_EQUAL_INT32(-6, RIGCAL_ERR_CAPACITY);
    TEST_ASSERT_EQUAL_INT32(-13, RIGCAL_ERR_NO_RAY);
    TEST_ASSERT_EQUAL_INT32(-20, RIGCAL_ERR_NO_POSE);
    TEST_ASSERT_EQUAL_INT32(-25, RIGCAL_ERR_MIRRORED);
}

/* Every number from the least to the largest is one status. */
static void test_the_numbers_of_statuses_have_no_gap(void)
{
    rigcal_status least = 0, largest = 0;

    for (int i = 0; i < N_STATUSES; i++) {
        least = STATUSES[i].status < least ? STATUSES[i].status : least;
        largest = STATUSES[i].status > largest ? STATUSES[i].status : largest;
        for (int j = 0; j < i; j++) {
            TEST_ASSERT_NOT_EQUAL_MESSAGE(STATUSES[j].status, STATUSES[i].status,
                                          STATUSES[i].name);
        }
    }
    TEST_ASSERT_EQUAL_INT(N_STATUSES, largest - least + 1);
}

/* A failure is negative, and ERR_ says so. */
static void test_a_negative_status_and_no_other_has_err_in_its_name(void)
{
    for (int i = 0; i < N_STATUSES; i++) {
        const int has_err = strncmp(STATUSES[i].name, "RIGCAL_ERR_", 11) == 0;

        TEST_ASSERT_EQUAL_INT_MESSAGE(STATUSES[i].status < 0, has_err, STATUSES[i].name);
    }
}

static void test_every_status_is_named_as_the_header_spells_it(void)
{
    for (int i = 0; i < N_STATUSES; i++) {
        TEST_ASSERT_EQUAL_STRING(STATUSES[i].name, rigcal_status_name(STATUSES[i].status));
    }
}

static void test_every_status_has_a_text_of_its_own(void)
{
    for (int i = 0; i < N_STATUSES; i++) {
        const char *text = rigcal_status_text(STATUSES[i].status);

        TEST_ASSERT_NOT_NULL(text);
        TEST_ASSERT_TRUE_MESSAGE(strlen(text) > 0, STATUSES[i].name);
        TEST_ASSERT_NOT_EQUAL_MESSAGE(0, strcmp(text, "unknown status"), STATUSES[i].name);
        TEST_ASSERT_NOT_EQUAL_MESSAGE(0, strcmp(text, STATUSES[i].name), STATUSES[i].name);
        for (int j = 0; j < i; j++) {
            TEST_ASSERT_NOT_EQUAL_MESSAGE(
                0, strcmp(text, rigcal_status_text(STATUSES[j].status)), STATUSES[i].name);
        }
    }
}

static void test_a_number_that_is_no_status_is_an_unknown_status(void)
{
    static const rigcal_status FAR[] = {INT32_MIN, INT32_MIN + 1, -65536,
                                        65536,     INT32_MAX - 1, INT32_MAX};

    for (rigcal_status s = -1000; s <= 1000; s++) {
        if (!is_status(s)) {
            TEST_ASSERT_EQUAL_STRING("unknown status", rigcal_status_name(s));
            TEST_ASSERT_EQUAL_STRING("unknown status", rigcal_status_text(s));
        }
    }
    for (size_t i = 0; i < sizeof FAR / sizeof FAR[0]; i++) {
        TEST_ASSERT_EQUAL_STRING("unknown status", rigcal_status_name(FAR[i]));
        TEST_ASSERT_EQUAL_STRING("unknown status", rigcal_status_text(FAR[i]));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_version_of_the_library_is_that_of_the_header);
    RUN_TEST(test_the_library_and_its_caller_agree_on_the_size_of_a_real);
    RUN_TEST(test_the_numbers_of_statuses_do_not_change);
    RUN_TEST(test_the_numbers_of_statuses_have_no_gap);
    RUN_TEST(test_a_negative_status_and_no_other_has_err_in_its_name);
    RUN_TEST(test_every_status_is_named_as_the_header_spells_it);
    RUN_TEST(test_every_status_has_a_text_of_its_own);
    RUN_TEST(test_a_number_that_is_no_status_is_an_unknown_status);
}
