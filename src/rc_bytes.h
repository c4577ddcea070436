/* rc_bytes.h - numbers as bytes, little-endian, of either precision, and their CRC. */
#ifndef RC_BYTES_H
#define RC_BYTES_H

#include "rc_real.h"

/* CRC-32 of IEEE 802.3, as in zlib, zip and PNG: reflected polynomial EDB88320, all ones
 * before, inverted after. */
uint32_t rc_crc32(const uint8_t bytes[], size_t n);

/* Both return the end of the bytes written. */
uint8_t *rc_put_u32(uint8_t *at, uint32_t x);
uint8_t *rc_put_reals(uint8_t *at, const rigcal_real x[], size_t n);

uint32_t rc_u16_at(const uint8_t *at);
uint32_t rc_u32_at(const uint8_t *at);

/* Reads reals of 4 or 8 bytes. Returns the end of the bytes read. A float build rounds
 * doubles to nearest; those too large and NaN become infinity. */
const uint8_t *rc_get_reals(rigcal_real x[], size_t n, const uint8_t *at,
                            int32_t real_bytes);

#endif /* RC_BYTES_H */
