#include "frames.h"

#ifdef __AVR__
#include <avr/pgmspace.h>
#else
#define PROGMEM
#define pgm_read_word(at) (*(at))
#endif

/* CRC-16/CCITT-FALSE of each value of the upper half of a byte: two steps a byte, and no more than 32 bytes of flash. */
static const uint16_t NIBBLES[16] PROGMEM = {
    0x0000, 0x1021, 0x2042, 0x3063, 0x4084, 0x50A5, 0x60C6, 0x70E7,
    0x8108, 0x9129, 0xA14A, 0xB16B, 0xC18C, 0xD1AD, 0xE1CE, 0xF1EF};

static uint16_t crc_step(uint16_t value, uint8_t nibble)
{
    return (uint16_t)(value << 4) ^ pgm_read_word(&NIBBLES[(uint8_t)(value >> 12) ^ nibble]);
}

uint16_t crc_of(const uint8_t *data, uint8_t size)
{
    uint16_t value = 0xFFFF;
    while (size--) {
        value = crc_step(value, *data >> 4);
        value = crc_step(value, *data++ & 15);
    }
    return value;
}

/* Undo COBS in place: a block of n bytes has n - 1; 0 where it cannot be one. */
static uint8_t unstuff(uint8_t *block, uint8_t size)
{
    uint8_t at = 0, out = 0;
    while (at < size) {
        uint8_t code = block[at];
        if (code > size - at)
            return 0;
        if (at)
            block[out++] = 0;
        for (uint8_t k = 1; k < code; k++)
            block[out++] = block[at + k];
        at = (uint8_t)(at + code);
    }
    return out;
}

bool read_byte(struct reader *reader, uint8_t byte)
{
    if (byte) {
        if (reader->size < MAX_BLOCK)
            reader->block[reader->size] = byte;
        if (reader->size <= MAX_BLOCK)
            reader->size++;
        return false;
    }
    uint8_t size = reader->size;
    reader->size = 0;
    if (!size)
        return false;
    uint8_t length = size <= MAX_BLOCK ? unstuff(reader->block, size) : 0;
    if (length < 4 || crc_of(reader->block, length - 2) != get_u16(reader->block + length - 2)) {
        reader->bad++;
        return false;
    }
    reader->length = length - 2;
    return true;
}

uint8_t stuff(const uint8_t *payload, uint8_t size, uint8_t *out)
{
    uint16_t crc = crc_of(payload, size);
    uint8_t mark = 0, at = 1;
    for (uint8_t k = 0; k < size + 2; k++) {
        uint8_t byte = k < size ? payload[k] : (uint8_t)(k == size ? crc : crc >> 8);
        if (byte) {
            out[at++] = byte;
        } else {
            out[mark] = at - mark;
            mark = at++;
        }
    }
    out[mark] = at - mark;
    out[at++] = 0;
    return at;
}

uint16_t get_u16(const uint8_t *at) { return (uint16_t)(at[0] | (uint16_t)at[1] << 8); }

uint32_t get_u32(const uint8_t *at) { return get_u16(at) | (uint32_t)get_u16(at + 2) << 16; }

uint8_t *put_u16(uint8_t *at, uint16_t value)
{
    *at++ = (uint8_t)value;
    *at++ = (uint8_t)(value >> 8);
    return at;
}

uint8_t *put_u32(uint8_t *at, uint32_t value) { return put_u16(put_u16(at, (uint16_t)value), (uint16_t)(value >> 16)); }
