/* Bytes of all kinds for the firmware's core, built with the sanitizers of gcc.

   usage: fuzz_core mutated|valid N SEED

   `mutated`: N frames that were changed, cut, doubled or mixed with others on the way to a core that is ready to be armed: none
   may arm it. `valid`: N requests with right frames and any body, on a table that moves as its motor is driven: whatever they
   are, the duty stays within its limit, the table within its stroke, and what is not armed is off. Prints how many were
   answered; exit 1 with a sentence where something is wrong. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core.h"

static uint64_t now;

static uint32_t any(uint32_t below)
{
    now ^= now << 13, now ^= now >> 7, now ^= now << 17;
    return (uint32_t)(now >> 20) % below;
}

static struct core c;
static unsigned long answered;

static unsigned give(const uint8_t *data, unsigned n)
{
    unsigned replies = 0;
    for (unsigned k = 0; k < n; k++) {
        uint8_t size = receive(&c, data[k]);
        if (size > MAX_REPLY || (size && c.reply[size - 1])) {
            printf("a reply of %u bytes\n", size);
            exit(1);
        }
        replies += size != 0;
    }
    answered += replies;
    return replies;
}

/* A frame; `payload` may have 76 bytes: stuffed with its CRC by plain code of its own. */
static unsigned framed(const uint8_t *payload, unsigned n, uint8_t *out)
{
    uint8_t raw[80];
    memcpy(raw, payload, n);
    uint16_t crc = crc_of(payload, (uint8_t)n);
    raw[n++] = (uint8_t)crc;
    raw[n++] = (uint8_t)(crc >> 8);
    unsigned mark = 0, at = 1;
    for (unsigned k = 0; k < n; k++) {
        if (raw[k]) {
            out[at++] = raw[k];
        } else {
            out[mark] = (uint8_t)(at - mark);
            mark = at++;
        }
    }
    out[mark] = (uint8_t)(at - mark);
    out[at++] = 0;
    return at;
}

static const uint8_t SIZES[] = {0, 1, 21, 0, 0, 0, 5, 6, 0, 6, 7, 0, 0, 0, 0};

static unsigned request(uint8_t *out, uint8_t type, int sensible)
{
    uint8_t payload[80] = {type, (uint8_t)any(256)};
    unsigned n = 2;
    if (type == SETPOINTS) {
        uint8_t points = (uint8_t)(1 + any(16));
        put_u32(payload + 2, sensible && any(4) ? c.next : any(100));
        payload[6] = points;
        for (unsigned k = 0; k < points; k++)
            put_u32(payload + 7 + 4 * k, (uint32_t)(c.position + (int32_t)any(200) - 100));
        n = 7 + 4 * points;
    } else {
        n += SIZES[type];
        for (unsigned k = 2; k < n; k++)
            payload[k] = (uint8_t)any(256);
        if (sensible && any(3)) {
            switch (type) {
            case HELLO: payload[2] = PROTOCOL; break;
            case LIMITS:
                put_u32(payload + 2, (uint32_t)(-1000 - (int32_t)any(36000)));
                put_u32(payload + 6, 1000 + any(36000));
                put_u32(payload + 10, 1 + any(40000));
                put_u16(payload + 14, (uint16_t)(50 + any(151)));
                put_u16(payload + 17, (uint16_t)(100 + any(901)));
                payload[19] = 0;
                payload[20] = (uint8_t)(1 + any(255));
                put_u16(payload + 21, (uint16_t)any(1023));
                break;
            case HOME:
                payload[2] = (uint8_t)any(2);
                put_u32(payload + 3, (uint32_t)((int32_t)any(2000) - 1000));
                break;
            case JOG:
                put_u32(payload + 2, (uint32_t)((int32_t)any(1200) - 600));
                put_u16(payload + 6, (uint16_t)(1 + any(500)));
                break;
            case FOLLOW:
                put_u16(payload + 2, (uint16_t)(1 + any(100)));
                put_u32(payload + 4, c.next + any(40));
                break;
            case REVERSE:
                put_u16(payload + 3, (uint16_t)(20 + any(2000)));
                put_u16(payload + 5, (uint16_t)any(500));
                put_u16(payload + 7, (uint16_t)(1 + any(5)));
                break;
            }
        }
    }
    return framed(payload, n, out);
}

static void say(uint8_t type, const uint8_t *body, unsigned n)
{
    uint8_t payload[40] = {type, (uint8_t)(type + 100)}, out[64];
    if (n)
        memcpy(payload + 2, body, n);
    give(out, framed(payload, n + 2, out));
}

static void get_ready(void)
{
    static const uint8_t limits[21] = {
        0xA8, 0xE4, 0xFF, 0xFF, 0x58, 0x1B, 0, 0, 0xC0, 0x5D, 0, 0, 200, 0, 255, 0xF4, 1, 0, 255, 0, 0};
    static const uint8_t version = PROTOCOL, place[5] = {0};
    restart(&c, 0);
    say(HELLO, &version, 1);
    say(CLEAR, 0, 0);
    say(LIMITS, limits, 21);
    say(HOME, place, 5);
    if (c.state != IDLE || !c.homed || !c.limited) {
        printf("it is not ready\n");
        exit(1);
    }
}

static unsigned mutate(uint8_t *data, unsigned n, unsigned most)
{
    for (unsigned times = 1 + any(3); times--;) {
        unsigned at = any(n), tail = any(40);
        switch (any(5)) {
        case 0: data[at] ^= (uint8_t)(1 << any(8)); break;
        case 1: data[at] = (uint8_t)any(256); break;
        case 2: data[at] = 0; break;
        case 3: n = at + 1; data[at] = 0; break;
        default:
            if (n + tail < most) {
                memmove(data + at + tail, data + at, n - at);
                for (unsigned k = 0; k < tail; k++)
                    data[at + k] = (uint8_t)any(256);
                n += tail;
            }
        }
    }
    return n;
}

/* Whether a frame is among these bytes as it was sent, after a 0 or at the start. */
static int intact(const uint8_t *data, unsigned n, const uint8_t *whole, unsigned size)
{
    for (unsigned at = 0; at + size <= n; at++)
        if ((at == 0 || !data[at - 1]) && !memcmp(data + at, whole, size))
            return 1;
    return 0;
}

static void mutated(unsigned long count)
{
    uint8_t data[512], whole[512];
    get_ready();
    for (unsigned long k = 0; k < count; k++) {
        unsigned n = request(whole, (uint8_t)(1 + any(14)), 1), m;
        do {
            memcpy(data, whole, n);
            m = mutate(data, n, sizeof data);
        } while (intact(data, m, whole, n));
        give(data, m);
        give((const uint8_t *)"", 1); /* a 0 */
        if (k % 50 == 0) {
            say(HEARTBEAT, 0, 0);
            tick(&c, (int32_t)any(50), false, 0, false, 0, 0);
        }
        if (enabled(&c) || c.duty) {
            printf("frame %lu armed it\n", k);
            exit(1);
        }
    }
    restart(&c, 0); /* and it still answers */
    get_ready();
}

static void valid(unsigned long count)
{
    uint8_t data[128];
    double place = 0.0, motor = 0.0;
    get_ready();
    for (unsigned long k = 0; k < count; k++) {
        give(data, request(data, (uint8_t)(any(4) ? 1 + any(14) : HEARTBEAT), 1));
        for (unsigned ms = any(30); ms--;) {
            int duty = c.duty, size = abs(duty);
            double wanted = size > 15 ? 65.0 * (size - 15) * (duty > 0 ? 1 : -1) : 0.0;
            motor += (wanted - motor) / (wanted == 0.0 ? 4.0 : 24.0);
            place += motor / 1000.0;
            if (place > 45000 || place < -45000) {
                place = place > 0 ? 45000 : -45000;
                motor = 0.0;
            }
            tick(&c, (int32_t)place, any(500) == 0, (int32_t)place, any(5000) == 0, any(50) ? 0 : (uint8_t)any(8),
                 (uint16_t)any(any(20) ? 100 : 1024));
            bool on = enabled(&c);
            if (abs(c.duty) > c.max_duty || (!on && c.duty) || c.next - c.head > QUEUE) {
                printf("request %lu: state %u, duty %d of %u, %u set points\n", k, c.state, c.duty, c.max_duty, c.next - c.head);
                exit(1);
            }
            if (on && c.homed && !c.outside && (c.position > c.high || c.position < c.low)) {
                printf("request %lu: at %d, armed, with limits of %d and %d\n", k, c.position, c.low, c.high);
                exit(1);
            }
        }
        if (any(2000) == 0)
            restart(&c, (int32_t)place);
    }
}

int main(int n, char **words)
{
    if (n != 4)
        return 2;
    now = strtoull(words[3], 0, 10) * 2654435761u + 88172645463325252ull;
    (words[1][0] == 'm' ? mutated : valid)(strtoul(words[2], 0, 10));
    printf("%lu\n", answered);
    return 0;
}
