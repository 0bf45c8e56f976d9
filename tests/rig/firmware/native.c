/* The firmware's core for a computer: its fields as one row of numbers, in an order that `field` names. */
#include <stdlib.h>

#include "core.h"

#define FIELDS(X) \
    X(state) X(faults) X(time) X(position) X(speed) X(duty) X(counts) X(offset) X(homed) X(limited) X(low) X(high) \
    X(max_speed) X(heartbeat) X(max_duty) X(stall) X(wired) X(slew) X(max_current) X(since) X(stalled) X(stall_at) X(free_travel) X(head) \
    X(next) X(last) X(period) X(phase) X(target) X(rate) X(left) X(half) X(pause) X(strokes) X(index) X(index_set) \
    X(shift) X(passes) X(turn_at) X(start) X(sign) X(end_seen) X(end_at) X(filled) X(inputs) X(outside) X(edge) \
    X(origin) X(way) X(way_at) X(proven) X(resting) X(current) X(over) X(jumped) X(slot)

#define NAME(field) #field,
static const char *const names[] = {FIELDS(NAME) 0};
#define WIDTH ((int)(sizeof names / sizeof *names) - 1)

const char *field(int k) { return names[k]; }

void store(const struct core *c, int64_t *row)
{
#define PUT(field) *row++ = c->field;
    FIELDS(PUT)
    for (int k = 0; k < QUEUE; k++)
        *row++ = c->queue[k];
    for (int k = 0; k < WINDOW; k++)
        *row++ = c->past[k];
}

void load(struct core *c, const int64_t *row)
{
#define GET(field) c->field = (__typeof__(c->field))*row++;
    FIELDS(GET)
    for (int k = 0; k < QUEUE; k++)
        c->queue[k] = (int32_t)*row++;
    for (int k = 0; k < WINDOW; k++)
        c->past[k] = (int32_t)*row++;
}

struct core *make(int32_t counts)
{
    struct core *c = malloc(sizeof *c);
    restart(c, counts);
    return c;
}

/* Bytes of the host; the replies go to `out`, which takes `room` bytes: how many there are, -1 where they are more. */
int feed(struct core *c, const uint8_t *data, int n, uint8_t *out, int room)
{
    int size = 0;
    for (int k = 0; k < n; k++) {
        int reply = receive(c, data[k]);
        if (reply > MAX_REPLY || size + reply > room)
            return -1;
        for (int j = 0; j < reply; j++)
            out[size++] = c->reply[j];
    }
    return size;
}

uint16_t bad_frames(const struct core *c) { return c->reader.bad; }

bool greeted(const struct core *c) { return c->greeted; }

void set_bad_frames(struct core *c, uint16_t bad) { c->reader.bad = bad; }
