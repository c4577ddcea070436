/* rc_bytes.h - numbers as bytes, little-endian, of either precision, and their CRC. */
#ifndef RC_BYTES_H
#define RC_BYTES_H

#include "rc_real.h"

/* CRC-32 of IEEE 802.3 (reflected polynomial EDB88320, all ones before, inverted
 * after), that of zlib, zip and PNG. */
uint32_t rc_crc32(const uint8_t bytes[], size_t n);

/* They return where the bytes end. */
uint8_t *rc_put_u32(uint8_t *at, uint32_t x);
uint8_t *rc_put_reals(uint8_t *at, const rigcal_real x[], size_t n);

uint32_t rc_u16_at(const uint8_t *at);
uint32_t rc_u32_at(const uint8_t *at);

/* Reals of 4 or 8 bytes; returns where they end. A float build rounds doubles to nearest,
 * too large ones and NaN to infinity. */
const uint8_t *rc_get_reals(rigcal_real x[], size_t n, const uint8_t *at,
                            int32_t real_bytes);

#endif /* RC_BYTES_H */
