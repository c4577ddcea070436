/* rigcal_config_cmsis_dsp.h - sine, cosine and square root in the manner of
 * CMSIS-DSP, a table and the FPU's instruction, but to float's full precision:
 *
 *     -DRIGCAL_CONFIG_FILE='"rigcal_config_cmsis_dsp.h"'
 *
 * and rigcal_tables.c compiled along. */
#ifndef RIGCAL_CONFIG_CMSIS_DSP_H
#define RIGCAL_CONFIG_CMSIS_DSP_H

#ifndef RIGCAL_USE_FLOAT
#define RIGCAL_USE_FLOAT 1
#endif
#if !RIGCAL_USE_FLOAT
#error "rigcal_tables.h is for float: RIGCAL_USE_FLOAT must be 1"
#endif

#define RIGCAL_MATH_HEADER "rigcal_tables.h"
#define RIGCAL_SIN(x) rigcal_table_sinf(x)
#define RIGCAL_COS(x) rigcal_table_cosf(x)
#define RIGCAL_SQRT(x) rigcal_fpu_sqrtf(x)

#endif /* RIGCAL_CONFIG_CMSIS_DSP_H */
