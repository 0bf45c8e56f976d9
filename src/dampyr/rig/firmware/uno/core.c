#include "core.h"

#include <string.h>

#define SPEED_PER_DUTY 65U /* counts/s: 15600 (78 mm/s) at duty 255, of which DEAD_DUTY is lost, /240 */
#define GAIN 40           /* 1/s: counts/s for each count away from the set point */
#define DEAD_DUTY 15      /* only overcomes friction */
#define AHEAD 24          /* ms: the motor's lag */
#define STILL 4           /* counts away from a resting set point that the brake may hold */
#define AWAY 1000L        /* counts from the set point */
#define STALL_DUTY 64
#define STALL_MOVE 2
#define FREE_TRAVEL 400L  /* counts that a free motor would have made */
#define CREEP 1000        /* counts/s, below which a load may hold the table for long */
#define STOP_TIME 60      /* ms */
#define FIRST_SWEEP 250   /* counts to the first turn of a search */
#define INDEX_SHIFT 2
#define SLOW 400          /* counts/s */
#define SLOW_BRAKE 600
#define SLOW_FAULT 1000
#define SLOW_AHEAD 80
#define SLOW_DUTY 64
#define SPARE 200         /* counts beyond what a search needs */
#define REVERSED 40
#define PROVEN 100
#define JUMP 60            /* counts in a millisecond: more than any motor makes */
#define OVER_TIME 20      /* ms for which the motor's current may be above the largest */
#define FULL_SCALE 1023   /* of the converter */
#define EDGE 100          /* counts that a table outside of the limits may go farther out */
#define FARTHEST 37000L   /* counts */
#define FASTEST 40000L    /* counts/s */

uint8_t extended_fuse = 0xFD; /* that of an Uno as it is sold */

static int32_t size_of(int32_t value) { return value < 0 ? -value : value; }

static int32_t kept_within(int32_t value, int32_t limit) { return value > limit ? limit : value < -limit ? -limit : value; }

bool enabled(const struct core *c) { return c->state >= ARMED && c->state <= STOPPING; }

static bool is_slow(const struct core *c) { return !c->homed || c->outside; }

static void forget_points(struct core *c) { c->head = c->next = 0; }

static void lose_place(struct core *c)
{
    c->homed = false;
    c->outside = 0;
    c->origin = c->counts;
}

static void fail(struct core *c, uint16_t faults)
{
    c->faults |= faults;
    c->state = FAULT;
    c->duty = 0;
    if (faults & (FAULT_ENCODER | FAULT_INDEX))
        lose_place(c);
    forget_points(c);
}

/* Begin to stop. */
static void rest(struct core *c)
{
    c->state = STOPPING;
    c->left = STOP_TIME;
    c->duty = 0;
    forget_points(c);
}

void restart(struct core *c, int32_t counts)
{
    memset(c, 0, sizeof *c);
    c->counts = c->position = c->origin = counts;
    c->state = FAULT;
    c->faults = FAULT_RESTARTED;
    c->since = UINT16_MAX;
}

/* what is looked at each millisecond */

static void observe(struct core *c, int32_t counts)
{
    c->slot = c->slot + 1 < WINDOW ? c->slot + 1 : 0;
    c->jumped = size_of(counts - c->counts) > JUMP;
    int32_t old = c->filled >= WINDOW ? c->past[c->slot] : counts;
    if (c->filled < WINDOW)
        c->filled++;
    c->past[c->slot] = counts;
    c->counts = counts;
    c->position = counts + c->offset;
    c->speed = (counts - old) * (RATE / WINDOW);
    if (c->outside && c->low <= c->position && c->position <= c->high)
        c->outside = 0;
}

/* The index was passed at a count: a search ends there, else it is compared with its place. */
static uint16_t see_index(struct core *c, int32_t index)
{
    if (c->state == HOMING) {
        c->offset = c->index - index;
        c->position = c->counts + c->offset;
        c->homed = c->index_set = true;
        c->passes = 1;
        c->shift = 0;
        rest(c);
    } else if (c->homed) {
        if (!c->index_set) { /* homed by hand: the first pass says where it is */
            c->index = index + c->offset;
            c->index_set = true;
        }
        c->passes++;
        c->shift = index + c->offset - c->index;
        if (size_of(c->shift) > INDEX_SHIFT)
            return FAULT_INDEX;
    }
    return 0;
}

/* The fault of a table outside of its limits, or, while it is not homed, farther than a stroke from where it was. */
static uint16_t beyond(const struct core *c)
{
    if (!c->homed) {
        int32_t gone = c->counts - c->origin, farthest = c->high - c->low + 2 * SPARE;
        return gone > farthest ? FAULT_HIGH : gone < -farthest ? FAULT_LOW : 0;
    }
    if (c->position < (c->outside < 0 ? c->edge : c->low))
        return FAULT_LOW;
    return c->position > (c->outside > 0 ? c->edge : c->high) ? FAULT_HIGH : 0;
}

static bool at_end(const struct core *c, int32_t way)
{
    if (!(c->wired & ENDS_WIRED))
        return false;
    return (way < 0 && (c->inputs & LOW_END)) || (way > 0 && (c->inputs & HIGH_END));
}

static bool both_ends(const struct core *c)
{
    return (c->wired & ENDS_WIRED) && (c->inputs & (LOW_END | HIGH_END)) == (LOW_END | HIGH_END);
}

/* Whether the table stands against its duty, as `is_stalled` has seen in this tick. */
static bool stands(const struct core *c) { return c->stalled >= c->stall || c->free_travel > FREE_TRAVEL * RATE; }

/* Whether much duty has moved nothing for too long, or any duty for as long as would make FREE_TRAVEL. */
static bool is_stalled(struct core *c)
{
    if (size_of(c->counts - c->stall_at) >= STALL_MOVE || c->duty == 0) {
        c->stall_at = c->counts;
        c->stalled = 0;
        c->free_travel = 0;
        return false;
    }
    uint16_t size = (uint16_t)(c->duty < 0 ? -c->duty : c->duty);
    if (size < STALL_DUTY)
        c->stalled = 0;
    else if (c->stalled < UINT16_MAX)
        c->stalled++;
    uint8_t lost = c->state == REVERSING ? STALL_DUTY : DEAD_DUTY;
    if (!c->resting && size > lost && c->free_travel <= FREE_TRAVEL * RATE)
        c->free_travel += (uint32_t)(size - lost) * SPEED_PER_DUTY;
    return stands(c);
}

/* Whether the motor's current has been above the largest for too long. */
static bool has_overcurrent(struct core *c)
{
    if (c->current <= c->max_current) /* 0 of 0 where it is not wired */
        c->over = 0;
    else if (c->over < UINT16_MAX)
        c->over++;
    return c->over > OVER_TIME;
}

/* Whether the table goes against the duty, until it has gone with it once: leads of motor or encoder are swapped. */
static bool goes_backwards(struct core *c)
{
    if (c->proven || c->duty == 0)
        return false;
    int8_t way = c->duty > 0 ? 1 : -1;
    if (way != c->way) {
        c->way = way;
        c->way_at = c->counts;
    }
    int32_t moved = way > 0 ? c->counts - c->way_at : c->way_at - c->counts;
    if (moved >= PROVEN)
        c->proven = true;
    return moved <= -REVERSED || (moved < 0 && size_of(c->speed) > SLOW_FAULT);
}

static uint16_t faults_now(struct core *c, bool glitch)
{
    uint16_t faults = beyond(c);
    int32_t speed = size_of(c->speed);
    if (c->since > c->heartbeat)
        faults |= FAULT_HEARTBEAT;
    if (!c->jumped && (speed > c->max_speed || (is_slow(c) && speed > SLOW_FAULT)))
        faults |= FAULT_SPEED;
    if (is_stalled(c) && c->state != HOMING) /* where a search takes it for the end of the stroke */
        faults |= FAULT_STALL;
    if (has_overcurrent(c))
        faults |= FAULT_CURRENT;
    if (goes_backwards(c))
        faults |= FAULT_DIRECTION;
    if (!c->jumped && c->state == FOLLOWING && size_of(c->target - c->position) > AWAY)
        faults |= FAULT_FOLLOWING;
    if ((c->wired & EMERGENCY_WIRED) && (c->inputs & PRESSED))
        faults |= FAULT_EMERGENCY;
    if (both_ends(c) || (c->state != HOMING && (at_end(c, c->duty) || at_end(c, c->speed))))
        faults |= FAULT_END;
    if (glitch || c->jumped)
        faults |= FAULT_ENCODER;
    return faults;
}

/* motion */

/* Duty in proportion to the distance, and for the speed that the set points ask for. */
static void towards(struct core *c, int32_t target, int32_t speed)
{
    int32_t away = target - c->position;
    c->resting = size_of(speed) < CREEP && !is_slow(c);
    if (speed == 0 && size_of(away) <= STILL) {
        c->duty = 0;
        return;
    }
    int32_t wanted = speed + GAIN * away, size = size_of(wanted);
    /* beyond 255 it makes no difference */
    int16_t duty = (int16_t)(DEAD_DUTY + (size > 66000 ? 1000 : (uint16_t)((uint32_t)size / SPEED_PER_DUTY)));
    c->duty = wanted == 0 ? 0 : wanted > 0 ? duty : -duty;
}

static int32_t point(const struct core *c, uint32_t number) { return c->queue[(uint8_t)number % QUEUE]; }

/* Counts per second from a set point to the next; of the last pair that is there where it is not, 0 after the end. */
static int32_t slope(const struct core *c, uint32_t number)
{
    if (number >= c->last)
        return 0;
    if (number > c->next - 2)
        number = c->next - 2;
    return (point(c, number + 1) - point(c, number)) * RATE / (int32_t)c->period;
}

static void follow(struct core *c)
{
    if (++c->phase >= c->period) {
        c->phase = 0;
        c->head++;
    }
    uint32_t head = c->head;
    if (head >= c->last) {
        c->state = ARMED;
        c->duty = 0;
        forget_points(c);
        return;
    }
    if (head + 1 >= c->next) {
        fail(c, FAULT_UNDERRUN);
        return;
    }
    if (size_of(slope(c, head)) > c->max_speed) {
        fail(c, FAULT_SPEED);
        return;
    }
    int32_t here = point(c, head), there = point(c, head + 1);
    c->target = here + (there - here) * (int32_t)c->phase / (int32_t)c->period;
    int32_t ahead = slope(c, head + (uint16_t)(c->phase + AHEAD) / c->period);
    towards(c, c->target, kept_within(ahead, c->max_speed));
}

static void reverse(struct core *c)
{
    uint32_t whole = (uint32_t)c->half + c->pause;
    c->resting = false;
    if (c->phase >= whole) {
        c->phase = 0;
        c->sign = -c->sign;
        c->strokes--;
    }
    c->phase++;
    if (c->strokes == 0) {
        rest(c);
        return;
    }
    uint32_t near = 2UL * c->phase, back = 2 * (whole - c->phase);
    if (back < near)
        near = back;
    if (c->half < near)
        near = c->half;
    int16_t duty = (int16_t)((uint32_t)c->rate * near / c->half);
    c->duty = c->sign > 0 ? duty : -duty;
}

/* Constant speed: the set point moves on from where it was, but never far from the table. */
static void glide(struct core *c)
{
    int32_t farthest = is_slow(c) ? SLOW_AHEAD : AWAY;
    c->target += c->rate;
    int32_t ahead = (c->target - c->position * RATE) / RATE;
    if (size_of(ahead) > farthest)
        c->target = (c->position + (ahead > 0 ? farthest : -farthest)) * RATE;
    towards(c, c->target / RATE, c->rate);
}

static void jog(struct core *c)
{
    if (c->left == 0) {
        rest(c);
        return;
    }
    c->left--;
    glide(c);
}

/* The search goes the other way, from where the table is. */
static void turn(struct core *c)
{
    c->sign = -c->sign;
    c->rate = c->sign * SLOW;
    c->target = c->position * RATE;
    c->duty = 0;
    c->stalled = 0;
    c->free_travel = 0;
}

/* To and fro about the start, each turn twice as far as the one before, until the index is passed. From an end of the
   stroke on it goes the other way only, to the other end. */
static void search(struct core *c)
{
    int32_t gone = c->sign > 0 ? c->position - c->start : c->start - c->position;
    int32_t reach = (c->high - c->low) / 2 + size_of(c->index) + SPARE;
    if (at_end(c, c->sign) || (stands(c) && c->duty != 0)) {
        if (c->end_seen && stands(c) && size_of(c->counts - c->end_at) < FIRST_SWEEP) {
            fail(c, FAULT_STALL);
        } else if (c->end_seen) {
            rest(c);
        } else {
            c->end_seen = true;
            c->end_at = c->counts;
            turn(c);
        }
    } else if (c->end_seen) {
        if (gone > c->high - c->low + SPARE)
            rest(c);
        else
            glide(c);
    } else if (gone >= c->turn_at && c->sign < 0 && c->turn_at >= reach) {
        rest(c);
    } else {
        if (gone >= c->turn_at) {
            if (c->sign < 0)
                c->turn_at = 2 * c->turn_at < reach ? 2 * c->turn_at : reach;
            turn(c);
        }
        glide(c);
    }
}

static void brake(struct core *c)
{
    c->duty = 0;
    c->left--;
    if (c->left == 0 || (c->speed == 0 && c->left <= STOP_TIME - WINDOW))
        c->state = ARMED;
}

static void act(struct core *c)
{
    int16_t before = c->duty;
    switch (c->state) {
    case FOLLOWING: follow(c); break;
    case REVERSING: reverse(c); break;
    case JOGGING: jog(c); break;
    case HOMING: search(c); break;
    case STOPPING: brake(c); break;
    default: c->duty = 0;
    }
    int16_t most = c->max_duty;
    if (is_slow(c)) {
        if (most > SLOW_DUTY)
            most = SLOW_DUTY;
        if ((c->speed > SLOW_BRAKE && c->duty > 0) || (c->speed < -SLOW_BRAKE && c->duty < 0))
            c->duty = 0;
    }
    if (c->duty > most)
        c->duty = most;
    if (c->duty < -most)
        c->duty = -most;
    if (c->duty == 0) /* the brake comes at once */
        return;
    if (c->duty > before + c->slew)
        c->duty = before + c->slew;
    if (c->duty < before - c->slew)
        c->duty = before - c->slew;
}

void tick(struct core *c, int32_t counts, bool latched, int32_t index, bool glitch, uint8_t inputs,
          uint16_t current)
{
    uint16_t faults = 0;
    c->time++;
    if (c->since < UINT16_MAX)
        c->since++;
    c->inputs = inputs;
    c->current = c->max_current ? current : 0;
    observe(c, counts);
    if (latched)
        faults = see_index(c, index);
    if (enabled(c)) {
        faults |= faults_now(c, glitch);
        if (faults)
            fail(c, faults);
    } else if (faults) {
        lose_place(c);
    }
    act(c);
}

/* requests */

static uint8_t free_places(const struct core *c) { return (uint8_t)(QUEUE - (c->next - c->head)); }

static uint8_t refuse_limits(const uint8_t *body)
{
    int32_t low = (int32_t)get_u32(body), high = (int32_t)get_u32(body + 4);
    uint32_t speed = get_u32(body + 8);
    uint16_t beat = get_u16(body + 12), stall = get_u16(body + 15);
    uint8_t duty = body[14], wired = body[17], slew = body[18];
    bool fine = wired <= (ENDS_WIRED | EMERGENCY_WIRED) && -FARTHEST <= low && low < high && high <= FARTHEST;
    fine = fine && speed >= 1 && speed <= FASTEST && beat >= 50 && beat <= 200 && duty >= 1 && slew >= 1;
    fine = fine && get_u16(body + 19) < FULL_SCALE;
    return fine && stall >= 100 && stall <= 1000 ? REASON_NONE : REASON_RANGE;
}

static uint8_t refuse_arm(const struct core *c)
{
    if (!c->limited)
        return REASON_NO_LIMITS;
    if ((c->wired & EMERGENCY_WIRED) && (c->inputs & PRESSED))
        return REASON_EMERGENCY;
    if (both_ends(c))
        return REASON_END;
    return c->since > c->heartbeat ? REASON_NO_HEARTBEAT : REASON_NONE;
}

static uint8_t refuse_home(const struct core *c, const uint8_t *body)
{
    int32_t counts = (int32_t)get_u32(body + 1);
    if (body[0] > 1 || counts > FARTHEST || counts < -FARTHEST)
        return REASON_RANGE;
    return body[0] == 1 && c->outside ? REASON_OUTSIDE : REASON_NONE;
}

static uint8_t refuse_jog(const struct core *c, const uint8_t *body)
{
    int32_t speed = (int32_t)get_u32(body);
    uint16_t time = get_u16(body + 4);
    if (time < 1 || time > 500 || speed > c->max_speed || speed < -c->max_speed)
        return REASON_RANGE;
    if (size_of(speed) > SLOW && !c->homed)
        return REASON_NOT_HOMED;
    if (c->outside && (size_of(speed) > SLOW || (c->outside > 0 ? speed > 0 : speed < 0)))
        return REASON_OUTSIDE;
    return at_end(c, speed) ? REASON_END : REASON_NONE;
}

static uint8_t refuse_points(const struct core *c, const uint8_t *body)
{
    uint32_t first = get_u32(body);
    uint8_t n = body[4];
    for (uint8_t k = 0; k < n; k++) {
        int32_t place = (int32_t)get_u32(body + 5 + 4 * k);
        if (place < c->low || place > c->high)
            return REASON_RANGE;
    }
    if (!c->homed)
        return REASON_NOT_HOMED;
    if (first > c->next)
        return REASON_GAP;
    if (c->state == FOLLOWING && first + n - 1 > c->last)
        return REASON_RANGE;
    return first + n > c->next + free_places(c) ? REASON_QUEUE_FULL : REASON_NONE;
}

static uint8_t refuse_follow(const struct core *c, const uint8_t *body)
{
    uint16_t period = get_u16(body);
    uint32_t n = get_u32(body + 2);
    if (period < 1 || period > 1000 || n < 1 || n < c->next)
        return REASON_RANGE;
    if (!c->homed)
        return REASON_NOT_HOMED;
    if (c->outside)
        return REASON_OUTSIDE;
    if (c->next == 0)
        return REASON_GAP;
    return size_of(c->queue[0] - c->position) > 100 ? REASON_RANGE : REASON_NONE;
}

static uint8_t refuse_reverse(const struct core *c, const uint8_t *body)
{
    uint16_t half = get_u16(body + 1);
    if (body[0] < 1 || body[0] > c->max_duty || half < 20 || half > 60000 || get_u16(body + 3) > 5000 || !get_u16(body + 5))
        return REASON_RANGE;
    if (!c->homed)
        return REASON_NOT_HOMED;
    return c->outside ? REASON_OUTSIDE : REASON_NONE;
}

/* Whether a request is carried out in this state at all. */
static bool in_state(const struct core *c, uint8_t type, const uint8_t *body)
{
    switch (type) {
    case LIMITS:
    case ARM: return c->state == IDLE;
    case HOME: return body[0] == 0 ? c->state == IDLE : body[0] == 1 ? c->state == ARMED : true;
    case JOG: return c->state == ARMED || c->state == JOGGING;
    case SETPOINTS: return c->state == ARMED || c->state == FOLLOWING;
    case FOLLOW:
    case REVERSE: return c->state == ARMED;
    case CLEAR: return c->state == FAULT;
    default: return true;
    }
}

/* Why a request cannot be carried out. */
static uint8_t refused(const struct core *c, uint8_t type, const uint8_t *body)
{
    if (!c->greeted && type != HELLO && type != STOP && type != ABORT && type != DISARM)
        return c->other_version ? REASON_VERSION : REASON_NO_HELLO;
    if (!in_state(c, type, body))
        return REASON_STATE;
    switch (type) {
    case LIMITS: return refuse_limits(body);
    case ARM: return refuse_arm(c);
    case HOME: return refuse_home(c, body);
    case JOG: return refuse_jog(c, body);
    case SETPOINTS: return refuse_points(c, body);
    case FOLLOW: return refuse_follow(c, body);
    case REVERSE: return refuse_reverse(c, body);
    default: return REASON_NONE;
    }
}

static void arm(struct core *c)
{
    forget_points(c);
    c->state = ARMED;
    c->stalled = 0;
    c->free_travel = 0;
    c->over = 0;
    c->duty = 0;
    c->way = 0;
    c->outside = 0;
    if (c->homed && (c->position < c->low || c->position > c->high)) {
        c->outside = c->position < c->low ? -1 : 1;
        c->edge = c->position + c->outside * EDGE;
    }
}

static void home(struct core *c, uint8_t how, int32_t counts)
{
    c->index_set = false;
    c->shift = 0;
    c->passes = 0;
    if (how == 0) {
        c->offset = counts - c->counts;
        c->position = counts;
        c->homed = true;
        return;
    }
    if (c->homed)
        lose_place(c);
    c->index = counts;
    c->start = c->position;
    c->target = c->position * RATE;
    c->turn_at = FIRST_SWEEP;
    c->state = HOMING;
    c->sign = 1;
    c->rate = SLOW;
    c->end_seen = false;
    forget_points(c);
}

static void take_points(struct core *c, const uint8_t *body)
{
    uint32_t number = get_u32(body);
    if (number == 0 && c->state == ARMED)
        forget_points(c);
    for (uint8_t k = 0; k < body[4]; k++, number++) {
        if (number >= c->next) {
            c->queue[(uint8_t)number % QUEUE] = (int32_t)get_u32(body + 5 + 4 * k);
            c->next = number + 1;
        }
    }
}

static void carry_out(struct core *c, uint8_t type, const uint8_t *body)
{
    switch (type) {
    case HELLO:
        c->greeted = body[0] == PROTOCOL;
        c->other_version = !c->greeted;
        if (c->other_version && enabled(c))
            fail(c, FAULT_ABORTED);
        break;
    case LIMITS:
        c->low = (int32_t)get_u32(body);
        c->high = (int32_t)get_u32(body + 4);
        c->max_speed = (int32_t)get_u32(body + 8);
        c->heartbeat = get_u16(body + 12);
        c->max_duty = body[14];
        c->stall = get_u16(body + 15);
        c->wired = body[17];
        c->slew = body[18];
        c->max_current = get_u16(body + 19);
        c->limited = true;
        break;
    case HEARTBEAT: c->since = 0; break;
    case ARM: arm(c); break;
    case DISARM:
        if (c->state != FAULT) {
            forget_points(c);
            c->state = IDLE;
            c->duty = 0;
        }
        break;
    case HOME: home(c, body[0], (int32_t)get_u32(body + 1)); break;
    case JOG:
        if (c->state != JOGGING) {
            c->target = c->position * RATE;
            forget_points(c);
        }
        c->state = JOGGING;
        c->rate = (int32_t)get_u32(body);
        c->left = get_u16(body + 4);
        break;
    case SETPOINTS: take_points(c, body); break;
    case FOLLOW:
        c->state = FOLLOWING;
        c->period = get_u16(body);
        c->last = get_u32(body + 2) - 1;
        c->phase = 0;
        c->target = c->queue[0];
        break;
    case REVERSE:
        c->state = REVERSING;
        c->rate = body[0];
        c->half = get_u16(body + 1);
        c->pause = get_u16(body + 3);
        c->strokes = get_u16(body + 5);
        c->phase = 0;
        c->sign = 1;
        forget_points(c);
        break;
    case STOP:
        if (c->state >= FOLLOWING && c->state <= HOMING)
            rest(c);
        break;
    case ABORT: fail(c, FAULT_ABORTED); break;
    case CLEAR:
        c->state = IDLE;
        c->faults = 0;
        break;
    }
}

/* The bytes of a request's body, 255 where they say themselves how many they are, 254 for what is no request. */
static uint8_t body_size(uint8_t type)
{
    switch (type) {
    case HELLO: return 1;
    case LIMITS: return 21;
    case HOME: return 5;
    case JOG:
    case FOLLOW: return 6;
    case REVERSE: return 7;
    case SETPOINTS: return 255;
    case HEARTBEAT:
    case ARM:
    case DISARM:
    case STOP:
    case ABORT:
    case CLEAR:
    case BUILD: return 0;
    default: return 254;
    }
}

static uint8_t *put_status(const struct core *c, uint8_t *at)
{
    uint8_t flags = enabled(c) | c->homed << 1 | c->limited << 2 | (c->outside != 0) << 3 | c->proven << 7;
    at = put_u32(at, c->time);
    *at++ = c->state;
    at = put_u16(at, c->faults);
    at = put_u32(at, (uint32_t)c->position);
    at = put_u32(at, (uint32_t)c->speed);
    at = put_u16(at, (uint16_t)c->duty);
    *at++ = flags | (uint8_t)(c->inputs << 4);
    *at++ = free_places(c);
    at = put_u32(at, c->next);
    at = put_u16(at, c->reader.bad);
    at = put_u16(at, (uint16_t)(c->shift < INT16_MIN ? INT16_MIN : c->shift > INT16_MAX ? INT16_MAX : c->shift));
    return put_u16(put_u16(at, c->passes), c->current);
}

uint8_t answer(struct core *c)
{
    const uint8_t *block = c->reader.block, *body = block + 2;
    uint8_t type = block[0], number = block[1], size = c->reader.length - 2, wanted = body_size(type);
    if (wanted == 255)
        wanted = (uint8_t)(size > 4 && body[4] >= 1 && body[4] <= 16 ? 5 + 4 * body[4] : 254);
    if (size != wanted) {
        c->reader.bad++;
        return 0;
    }
    if (c->answered && type == c->last_type && number == c->last_number)
        return c->reply_size; /* a repeat is answered again and not carried out again */
    uint8_t payload[MAX_REPLY - 4], *at = payload + 2, reason = refused(c, type, body);
    payload[1] = number;
    if (reason) {
        payload[0] = REPLY_NAK;
        *at++ = type;
        *at++ = reason;
    } else {
        carry_out(c, type, body);
        if (type == HELLO) {
            payload[0] = REPLY_HELLO;
            *at++ = PROTOCOL;
            at = put_u16(put_u16(at, FIRMWARE), RATE);
            *at++ = QUEUE;
        } else if (type == HEARTBEAT) {
            payload[0] = REPLY_STATUS;
            at = put_status(c, at);
        } else if (type == BUILD) {
            payload[0] = REPLY_BUILD;
            *at++ = DIRECTION_PIN;
            at = put_u32(put_u32(at, BAUD), DIGEST);
            *at++ = extended_fuse;
        } else {
            payload[0] = REPLY_ACK;
            *at++ = type;
            *at++ = free_places(c);
        }
    }
    c->reply_size = stuff(payload, (uint8_t)(at - payload), c->reply);
    c->answered = true;
    c->last_type = type;
    c->last_number = number;
    return c->reply_size;
}

uint8_t receive(struct core *c, uint8_t byte) { return read_byte(&c->reader, byte) ? answer(c) : 0; }
