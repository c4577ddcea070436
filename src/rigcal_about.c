#include "rc_real.h"

int32_t rigcal_version(void)
{
    return RIGCAL_VERSION_MAJOR * 10000 + RIGCAL_VERSION_MINOR * 100 + RIGCAL_VERSION_PATCH;
}

int32_t rigcal_sizeof_real(void)
{
    return (int32_t)sizeof(rigcal_real);
}

/* A switch, because a table of pointers needs relocation in a shared library, which makes
 * it writable data while it loads. */

#define NAME_OF(name, number, text) \
    case name: \
        return #name;
#define TEXT_OF(name, number, text) \
    case name: \
        return text;

const char *rigcal_status_name(rigcal_status status)
{
    switch (status) {
        RIGCAL_STATUSES(NAME_OF)
    default:
        return "unknown status";
    }
}

const char *rigcal_status_text(rigcal_status status)
{
    switch (status) {
        RIGCAL_STATUSES(TEXT_OF)
    default:
        return "unknown status";
    }
}
