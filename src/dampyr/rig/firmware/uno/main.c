/* The Arduino Uno (ATmega328P, 16 MHz) of the test platform: its pins, timers and interrupts. docs/reference/protocol.md has the
   pins; core.c does what they are for. */
#include <avr/boot.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/wdt.h>

#include "core.h"

/* The line's divider, rounded: what it makes of the clock is within 2.2 %: that of 115200, with which
   every Uno talks. 57600, 115200, 250000, 500000 and 1000000 are; 230400 is 8.5 % off. */
#define DIVIDER ((F_CPU + 4UL * BAUD) / (8UL * BAUD) - 1)
#define LINE (F_CPU / (8UL * (DIVIDER + 1))) /* the speed that comes of it */
_Static_assert(DIVIDER <= 4095, "BAUD is too low for this clock: give at least 489");
_Static_assert((LINE > BAUD ? LINE - BAUD : BAUD - LINE) * 1000UL <= BAUD * 22UL,
               "BAUD cannot be made of this clock within 2.2 %: give 57600, 115200, 250000, 500000 or 1000000");

#define DEBOUNCE 5 /* ms that an input has to be open */
#define RX_SIZE 128 /* 5 ms of bytes; the loop takes them within one */
#define TX_SIZE 64

static struct core core;

/* The encoder: what its interrupts have counted since the last millisecond. They are kept short: an edge comes each 41 us. */
static volatile int8_t moved, latched_at;
static volatile bool is_latched, has_glitch;
static volatile int8_t way; /* of the last count */
static uint8_t lines;
#define BOTH 2
static const int8_t CHANGE[16] = {0, 1, -1, BOTH, -1, 0, BOTH, 1, 1, BOTH, 0, -1, BOTH, -1, 1, 0}; /* B A before, B A now */

static void count_edge(void)
{
    uint8_t now = (PIND >> 2) & 3;
    int8_t change = CHANGE[(uint8_t)(lines << 2) | now];
    lines = now;
    if (change == BOTH) {
        has_glitch = true;
    } else if (change) {
        moved += change;
        way = change;
    }
}

ISR(INT0_vect) { count_edge(); }

ISR(INT1_vect, ISR_ALIASOF(INT0_vect));

/* The index: one physical edge of the mark, its rising one on the way up, its falling one on the way down. */
ISR(PCINT2_vect)
{
    bool high = PIND & _BV(4);
    if ((high && way > 0) || (!high && way < 0)) {
        latched_at = moved;
        is_latched = true;
    }
}

/* The serial line. */
static volatile uint8_t rx[RX_SIZE], rx_head, rx_tail, tx[TX_SIZE], tx_head, tx_tail;

ISR(USART_RX_vect)
{
    uint8_t byte = UDR0, next = (rx_head + 1) % RX_SIZE;
    if (next != rx_tail) { /* else it is lost, which the frame's CRC shows */
        rx[rx_head] = byte;
        rx_head = next;
    }
}

ISR(USART_UDRE_vect)
{
    if (tx_tail == tx_head) {
        UCSR0B &= (uint8_t)~_BV(UDRIE0);
    } else {
        UDR0 = tx[tx_tail];
        tx_tail = (tx_tail + 1) % TX_SIZE;
    }
}

/* Queue a reply; where there is no place for it, it is left out, and the host asks again. */
static void send(const uint8_t *data, uint8_t size)
{
    if ((uint8_t)(tx_tail - tx_head - 1) % TX_SIZE < size)
        return;
    for (uint8_t k = 0; k < size; k++) {
        tx[tx_head] = data[k];
        tx_head = (tx_head + 1) % TX_SIZE;
    }
    UCSR0B |= _BV(UDRIE0);
}

/* Each millisecond. */
static volatile uint8_t due, done; /* milliseconds to be worked on; those that were, modulo 256 */
static volatile bool busy;         /* whether the core is being worked on */
static int32_t counts, index_at;
static bool index_passed, glitch;

/* Which inputs have been open for long enough. */
static uint8_t open_inputs(void)
{
    static uint8_t open_for[3];
    uint8_t pins = (uint8_t)((PIND >> 5 & 3) | (PINB >> 3 & 1) << 2), inputs = 0;
    for (uint8_t k = 0; k < 3; k++) {
        if (!(pins & 1 << k))
            open_for[k] = 0;
        else if (open_for[k] < DEBOUNCE)
            open_for[k]++;
        if (open_for[k] == DEBOUNCE)
            inputs |= (uint8_t)(1 << k);
    }
    return inputs;
}

/* The larger of the bridge's two current outputs, A0 and A1: each is read in every second millisecond. */
static uint16_t motor_current(void)
{
    static uint16_t readings[2];
    static uint8_t input;
    readings[input] = ADC;
    input ^= 1;
    ADMUX = _BV(REFS0) | input; /* 5 V is the full scale */
    ADCSRA |= _BV(ADSC);        /* 104 us, and done at the next millisecond */
    return readings[0] > readings[1] ? readings[0] : readings[1];
}

static void drive(void)
{
    int16_t duty = core.duty;
    if (enabled(&core))
        PORTB |= _BV(0);
    else
        PORTB &= (uint8_t)~_BV(0);
#if DIRECTION_PIN
    if (duty < 0)
        PORTB |= _BV(2);
    else
        PORTB &= (uint8_t)~_BV(2);
    OCR1A = (uint8_t)(duty < 0 ? -duty : duty);
#else
    OCR1A = (uint8_t)(duty > 0 ? duty : 0);
    OCR1B = (uint8_t)(duty < 0 ? -duty : 0);
#endif
}

static void work(void)
{
    PORTB |= _BV(5); /* D13, for an oscilloscope */
    cli();
    int32_t now = counts, index = index_at;
    bool passed = index_passed, both = glitch;
    index_passed = glitch = false;
    due = 0;
    sei();
    tick(&core, now, passed, index, both, open_inputs(), motor_current());
    drive();
    done++;
    PORTB &= (uint8_t)~_BV(5);
}

/* The counts are taken at the millisecond, whatever is being worked on; the work follows at once, or once a request has been
   answered. Meanwhile the encoder and the serial line interrupt it. */
ISR(TIMER2_COMPA_vect)
{
    if (is_latched) {
        index_at = counts + latched_at;
        index_passed = true;
        is_latched = false;
    }
    glitch |= has_glitch;
    has_glitch = false;
    counts += moved;
    moved = 0;
    due++;
    if (busy)
        return;
    busy = true;
    sei();
    work();
    cli();
    busy = false;
}

static void serve(void)
{
    busy = true; /* of the interrupt's doing only after this: it is one byte, and nothing else writes it meanwhile */
    uint8_t size = answer(&core);
    if (size)
        send(core.reply, size);
    drive(); /* an abort does not wait for the next millisecond */
    cli();
    while (due) {
        sei();
        work();
        cli();
    }
    busy = false;
    sei();
}

/* A boot loader, or the watchdog's own reset, may have left it on. */
void watchdog_off(void) __attribute__((naked, used, section(".init3")));
void watchdog_off(void)
{
    MCUSR = 0;
    wdt_disable();
}

static void set_up(void)
{
    PORTD = _BV(2) | _BV(3) | _BV(4) | _BV(5) | _BV(6) | _BV(7); /* pulled up; D7, the bridge, is on: the brake needs it */
    DDRD = _BV(7);
    PORTB = _BV(3);
    DDRB = _BV(0) | _BV(1) | _BV(2) | _BV(5); /* D8 enable, D9 and D10 bridge, D13 */
    TCCR1A = _BV(WGM10) | _BV(COM1A1) | (DIRECTION_PIN ? 0 : _BV(COM1B1)); /* phase-correct, top 255 */
    TCCR1B = _BV(CS10);
    TCCR2A = _BV(WGM21);
    OCR2A = F_CPU / 64 / RATE - 1;
    TCCR2B = _BV(CS22); /* /64 */
    TIMSK2 = _BV(OCIE2A);
    lines = (PIND >> 2) & 3;
    EICRA = _BV(ISC00) | _BV(ISC10); /* every edge of A and B */
    EIMSK = _BV(INT0) | _BV(INT1);
    PCMSK2 = _BV(PCINT20);
    PCICR = _BV(PCIE2);
    ADMUX = _BV(REFS0);
    ADCSRA = _BV(ADEN) | _BV(ADSC) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0); /* 125 kHz */
    DIDR0 = _BV(ADC0D) | _BV(ADC1D);
    UBRR0 = DIVIDER;
    UCSR0A = _BV(U2X0);
    UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
}

int main(void)
{
    restart(&core, 0);
    extended_fuse = boot_lock_fuse_bits_get(GET_EXTENDED_FUSE_BITS); /* before interrupts are on: its two steps are timed */
    set_up();
    wdt_enable(WDTO_15MS);
    sei();
    for (uint8_t fed = 0;;) {
        if (fed != done) { /* a millisecond's work was done */
            fed = done;
            wdt_reset();
        }
        while (rx_tail != rx_head) {
            uint8_t byte = rx[rx_tail];
            rx_tail = (rx_tail + 1) % RX_SIZE;
            if (read_byte(&core.reader, byte))
                serve();
        }
    }
}
