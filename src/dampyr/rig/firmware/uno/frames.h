/* Frames of docs/reference/protocol.md: COBS, CRC-16/CCITT-FALSE, and a reader that takes one byte at a time. */
#ifndef DAMPYR_FRAMES_H
#define DAMPYR_FRAMES_H

#include <stdbool.h>
#include <stdint.h>

#define MAX_BODY 70
#define MAX_PAYLOAD (2 + MAX_BODY + 2) /* type, number, body, CRC */
#define MAX_BLOCK (MAX_PAYLOAD + 1)    /* between two zeros */
#define MAX_REPLY 40                   /* a STATUS takes 37 bytes with its 0 */

struct reader {
    uint8_t block[MAX_BLOCK]; /* what has come since the last 0; after `read_byte` says so, a payload */
    uint8_t size;             /* more than MAX_BLOCK: too long to be a frame */
    uint8_t length;           /* of the payload, without its CRC */
    uint16_t bad;             /* frames dropped; it wraps */
};

uint16_t crc_of(const uint8_t *data, uint8_t size);

/* Take a byte; whether `block` now holds a payload with a right CRC, of `length` bytes. */
bool read_byte(struct reader *reader, uint8_t byte);

/* Stuff a payload of at most MAX_REPLY - 4 bytes with its CRC; the size with the closing 0. */
uint8_t stuff(const uint8_t *payload, uint8_t size, uint8_t *out);

uint16_t get_u16(const uint8_t *at);
uint32_t get_u32(const uint8_t *at);
uint8_t *put_u16(uint8_t *at, uint16_t value);
uint8_t *put_u32(uint8_t *at, uint32_t value);

#endif
