/* What the firmware does a thousand times a second, and what it makes of a request: docs/reference/protocol.md, to the count.

   Nothing here knows of the chip: the same code is compiled for a computer, where tests run it against a model in Python. */
#ifndef DAMPYR_CORE_H
#define DAMPYR_CORE_H

#include <stdbool.h>
#include <stdint.h>

#include "frames.h"

#define PROTOCOL 3
#define FIRMWARE 0x0300 /* major, minor */
#define RATE 1000       /* Hz */
#define QUEUE 64
#define WINDOW 10

/* What the program was built with, which BUILD says; the Makefile gives the three. */
#ifndef BAUD
#define BAUD 250000UL
#endif
#ifndef DIRECTION_PIN
#define DIRECTION_PIN 0 /* 1: D9 is the PWM and D10 the direction; 0: a PWM each, D9 extends */
#endif
#ifndef DIGEST
#define DIGEST 0UL /* the first four bytes of the SHA-256 of the sources */
#endif

enum { HELLO = 1, LIMITS, HEARTBEAT, ARM, DISARM, HOME, JOG, SETPOINTS, FOLLOW, REVERSE, STOP, ABORT, CLEAR, BUILD };
enum { REPLY_HELLO = 0x81, REPLY_ACK, REPLY_NAK, REPLY_STATUS, REPLY_BUILD };
enum { IDLE, ARMED, FOLLOWING, REVERSING, JOGGING, HOMING, STOPPING, FAULT };
enum {
    FAULT_HEARTBEAT = 1, FAULT_LOW = 2, FAULT_HIGH = 4, FAULT_SPEED = 8, FAULT_STALL = 16, FAULT_FOLLOWING = 32,
    FAULT_UNDERRUN = 64, FAULT_ENCODER = 128, FAULT_ABORTED = 256, FAULT_RESTARTED = 512, FAULT_INDEX = 1024,
    FAULT_END = 2048, FAULT_EMERGENCY = 4096, FAULT_DIRECTION = 8192, FAULT_CURRENT = 16384
};
enum {
    REASON_NONE, REASON_STATE, REASON_RANGE, REASON_NOT_HOMED, REASON_NO_LIMITS, REASON_QUEUE_FULL, REASON_GAP,
    REASON_VERSION, REASON_NO_HEARTBEAT, REASON_NO_HELLO, REASON_OUTSIDE, REASON_END, REASON_EMERGENCY
};
enum { LOW_END = 1, HIGH_END = 2, PRESSED = 4 };     /* inputs that are open */
enum { ENDS_WIRED = 1, EMERGENCY_WIRED = 2 };        /* which of them LIMITS say are wired */

struct core {
    uint32_t time;
    uint8_t state;
    uint16_t faults;
    int32_t counts, offset, position, speed;
    int16_t duty;
    bool homed, limited, jumped;  /* jumped: the count, in this millisecond, by more than any motor makes */
    /* LIMITS */
    int32_t low, high, max_speed;
    uint16_t heartbeat, stall;
    uint8_t max_duty, wired, slew;
    uint16_t max_current;         /* steps of the converter; 0: the bridge's current sense is not wired */
    uint16_t since;               /* ms since the last HEARTBEAT, at most 65535 */
    /* CURRENT */
    uint16_t current;             /* steps of the converter, as last read; 0 where it is not wired */
    uint16_t over;                /* ms on end above the largest */
    /* STALL, DIRECTION */
    uint16_t stalled;
    int32_t stall_at;
    uint32_t free_travel;         /* thousandths of a count that a free motor would have made */
    bool resting, proven;
    int8_t way;
    int32_t way_at;
    /* motion */
    uint32_t head, next, last;    /* numbers of set points: the current one, the next to come, the last */
    uint16_t period, phase;
    int32_t target, rate;
    uint16_t left, half, pause, strokes;
    int8_t sign;
    int32_t queue[QUEUE];
    /* index and search */
    int32_t index, start, turn_at, end_at;
    bool index_set, end_seen;
    int32_t shift;
    uint16_t passes;
    uint8_t inputs;
    int8_t outside;
    int32_t edge, origin;
    int32_t past[WINDOW];
    uint8_t slot, filled;
    /* dialogue */
    bool greeted, other_version, answered;
    uint8_t last_type, last_number, reply_size;
    uint8_t reply[MAX_REPLY];
    struct reader reader;
};

/* The chip's extended fuse, which holds its brown-out level; the program reads it as it starts. */
extern uint8_t extended_fuse;

/* As after power-on or the watchdog: FAULT with RESTARTED; `counts` is where the encoder's counter stands. */
void restart(struct core *c, int32_t counts);

/* A byte of the host: the size of the reply in `c->reply`, 0 where there is none. */
uint8_t receive(struct core *c, uint8_t byte);

/* The reply to the payload in `c->reader`. */
uint8_t answer(struct core *c);

/* One millisecond: the encoder's counts, whether its index was passed (`latched`) and at which count, whether both lines
   changed at once (`glitch`), which inputs are open, and the larger reading of the bridge's two current outputs (`current`). */
void tick(struct core *c, int32_t counts, bool latched, int32_t index, bool glitch, uint8_t inputs,
          uint16_t current);

/* Whether the enable line is high. */
bool enabled(const struct core *c);

#endif
