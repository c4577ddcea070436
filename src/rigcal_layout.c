#include "rc_layout.h"

#define STRUCT(type) {#type, 0, (int32_t)sizeof(type)},
#define FIELD(type, field) \
    {#type "." #field, (int32_t)offsetof(type, field), (int32_t)sizeof(((type *)0)->field)},

/* If a field is a pointer, the size of the pointer is meant. */
/* NOLINTNEXTLINE(bugprone-sizeof-expression) */
static const rigcal_layout_entry LAYOUT[] = {RC_LAYOUT(STRUCT, FIELD)};

int32_t rigcal_layout_count(void)
{
    return (int32_t)(sizeof LAYOUT / sizeof LAYOUT[0]);
}

rigcal_status rigcal_layout(rigcal_layout_entry *entry, int32_t index)
{
    if (entry == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (index < 0 || index >= rigcal_layout_count()) {
        return RIGCAL_ERR_RANGE;
    }
    *entry = LAYOUT[index];
    return RIGCAL_OK;
}
