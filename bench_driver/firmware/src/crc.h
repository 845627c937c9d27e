// CRC-32 of Ethernet and zlib.
#ifndef CRC_H
#define CRC_H

#include <stdint.h>

uint32_t crc32(const uint8_t *data, uint8_t length);

#endif
