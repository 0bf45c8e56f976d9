/* The firmware's binary in simavr, a millisecond at a time: a test program of its own, linked with simavr (GPL-3).

   usage: uno_in_simavr ELF MARK [BAUD]      MARK: the encoder's count at which its index is; BAUD: of the host, 250000

   Each millisecond it reads   i16 counts to move, u8 inputs that are open, u8 what (1: both lines of the encoder change at once,
   2: reset, 4: the main loop hangs until the next reset, 8: two counts that no motion made, 16 and 32: A0 and A1 at 2.5 V), u16 n, n bytes for the serial
   line; and writes   u8 OCR1A, u8 OCR1B (0 where its pin has no PWM), u8 outputs of PORTB, u8 PORTD, u8 whether the chip still runs, u16 longest work since the start
   [cycles], u16 least stack pointer, u32 resets, u16 n, n bytes of the serial line. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <simavr/avr_adc.h>
#include <simavr/avr_extint.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>

#define CYCLES 16000 /* of a millisecond */

static avr_t *avr;
static avr_irq_t *a, *b, *z, *uart;
static uint8_t sent[65536], waiting[65536];
static unsigned n_sent, n_waiting;
static int ready = 1;
static long place, offset;
static uint16_t longest, least = 0xFFFF;
static uint32_t resets;
static avr_cycle_count_t began, byte_takes;

static void output(struct avr_irq_t *irq, uint32_t value, void *given)
{
    (void)irq, (void)given;
    sent[n_sent++ % sizeof sent] = (uint8_t)value;
}

static void flow(struct avr_irq_t *irq, uint32_t value, void *given)
{
    (void)irq;
    if (value)
        ready = given != 0;
}

static void working(struct avr_irq_t *irq, uint32_t value, void *given)
{
    (void)irq, (void)given;
    if (value)
        began = avr->cycle;
    else if (began && avr->cycle - began > longest)
        longest = (uint16_t)(avr->cycle - began);
}

/* What is outside of a port's pins, where the chip itself does not drive them. */
static void put(char name, uint8_t mask, uint8_t value)
{
    avr_ioport_external_t external = {.name = (unsigned long)name, .mask = mask, .value = value};
    avr_ioctl(avr, AVR_IOCTL_IOPORT_SET_EXTERNAL(name), &external);
}

/* A hang: the instruction at which the main loop is now jumps to itself. */
static uint32_t hung_at;
static uint8_t hung[2];

static void unhang(void)
{
    if (hung_at)
        memcpy(avr->flash + hung_at, hung, 2);
    hung_at = 0;
}

static void hang(void)
{
    hung_at = avr->pc;
    memcpy(hung, avr->flash + hung_at, 2);
    avr->flash[hung_at] = 0xFF;
    avr->flash[hung_at + 1] = 0xCF;
}

static void run_to(avr_cycle_count_t until)
{
    while (avr->cycle < until) {
        uint32_t before = avr->pc;
        int state = avr_run(avr);
        if (state == cpu_Done || state == cpu_Crashed)
            return;
        if (avr->pc == 0 && before != 0) {
            resets++;
            unhang();
        }
        uint16_t sp = (uint16_t)(avr->data[R_SPL] | avr->data[R_SPH] << 8);
        if (sp < least && sp > 0x100) /* it is 0 before the program has set it */
            least = sp;
    }
}

static void show(void)
{
    static const int order[4] = {0, 1, 3, 2}; /* A first, in extension */
    int pair = order[(place + offset) & 3];
    avr_raise_irq(a, pair & 1);
    avr_raise_irq(b, pair >> 1);
}

static void step(int way, long mark)
{
    if (way < 0 && place == mark) { /* the mark's physical edge lies between two counts */
        avr_raise_irq(z, 0);
        run_to(avr->cycle + 100);
    }
    place += way;
    show();
    run_to(avr->cycle + 100);
    if (way > 0 && place == mark + 1)
        avr_raise_irq(z, 0);
    else if (place == mark)
        avr_raise_irq(z, 1);
}

static int get(void *data, size_t size) { return fread(data, 1, size, stdin) == size; }

int main(int count, char **words)
{
    FILE *out = fdopen(dup(1), "wb"); /* simavr prints on the standard output */
    dup2(2, 1);
    elf_firmware_t firmware = {0};
    if (count < 3 || count > 4 || elf_read_firmware(words[1], &firmware)) {
        fprintf(stderr, "usage: uno_in_simavr ELF MARK [BAUD]\n");
        return 2;
    }
    long mark = atol(words[2]);
    byte_takes = 160000000 / (count == 4 ? atol(words[3]) : 250000);
    avr = avr_make_mcu_by_name("atmega328p");
    avr_init(avr);
    avr->log = LOG_ERROR;
    firmware.frequency = 16000000;
    firmware.vcc = firmware.avcc = firmware.aref = 5000; /* mV */
    avr_load_firmware(avr, &firmware);
    uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
    flags &= ~(uint32_t)(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    avr_extint_set_strict_lvl_trig(avr, 0, 0); /* else a pin that is low at first interrupts for ever */
    avr_extint_set_strict_lvl_trig(avr, 1, 0);
    uart = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), output, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON), flow, &ready);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF), flow, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), 5), working, NULL);
    a = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), 2);
    b = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), 3);
    z = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), 4);
    put('D', 0x7C, 0); /* else simavr shows its pull-ups when the program sets them */
    show();
    for (;;) {
        int16_t move;
        uint8_t inputs, what;
        uint16_t n;
        if (!get(&move, 2) || !get(&inputs, 1) || !get(&what, 1) || !get(&n, 2))
            return 0;
        for (unsigned k = 0; k < n; k++) {
            uint8_t byte;
            if (!get(&byte, 1))
                return 0;
            waiting[n_waiting++ % sizeof waiting] = byte;
        }
        put('D', 0x7C, (uint8_t)((inputs & 3) << 5 | (a->value & 1) << 2 | (b->value & 1) << 3 | (z->value & 1) << 4));
        put('B', 0x08, (uint8_t)((inputs & 4) << 1));
        for (int k = 0; k < 3; k++) {
            avr_irq_t *pin = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(k < 2 ? 'D' : 'B'), k < 2 ? 5 + k : 3);
            avr_raise_irq(pin, !(inputs >> k & 1));
            avr_raise_irq(pin, inputs >> k & 1);
        }
        if (what & 2) {
            avr_reset(avr);
            resets++;
        }
        for (int k = 0; k < 2; k++)
            avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, k), what >> (4 + k) & 1 ? 2500 : 0);
        if (what & 4)
            hang();
        if (what & 8) /* the encoder shows two counts more than the table has gone, here and from now on */
            for (int k = 0; k < 2; k++) {
                offset++;
                show();
                run_to(avr->cycle + 100);
            }
        if (what & 1) {
            place += 2;
            show();
            place -= 2; /* where it is does not change */
            run_to(avr->cycle + 100);
            show();
        }
        static unsigned taken;
        static avr_cycle_count_t next_byte, end;
        end += CYCLES;
        avr_cycle_count_t from = avr->cycle;
        int steps = abs(move), done = 0;
        n_sent = 0;
        while (avr->cycle < end) {
            avr_cycle_count_t to = end;
            if (taken < n_waiting) {
                if (avr->cycle >= next_byte && ready) {
                    avr_raise_irq(uart, waiting[taken++ % sizeof waiting]);
                    next_byte = avr->cycle + byte_takes;
                }
                if (next_byte > avr->cycle && next_byte < to)
                    to = next_byte;
                else if (to > avr->cycle + 50)
                    to = avr->cycle + 50;
            }
            if (done < steps) {
                avr_cycle_count_t at = from + (end - from) * (unsigned)done / (unsigned)steps;
                if (avr->cycle >= at) {
                    step(move > 0 ? 1 : -1, mark);
                    done++;
                    continue;
                }
                if (at < to)
                    to = at;
            }
            run_to(to);
            if (avr->state == cpu_Done || avr->state == cpu_Crashed)
                break;
        }
        uint8_t running = avr->state != cpu_Done && avr->state != cpu_Crashed;
        /* D9 and D10: what timer 1 drives (COM1A1, COM1B1) is no port's, and neither is shown where the pin is an input */
        uint8_t timer = avr->data[0x80], out_b = avr->data[0x24];
        uint8_t port_b = avr->data[0x25] & (uint8_t)~((timer & 0x80 ? 2 : 0) | (timer & 0x20 ? 4 : 0)) & out_b;
        uint8_t one = timer & 0x80 && out_b & 2 ? avr->data[0x88] : 0, other = timer & 0x20 && out_b & 4 ? avr->data[0x8A] : 0;
        uint8_t pins[5] = {one, other, port_b, avr->data[0x2B], running};
        uint16_t size = (uint16_t)n_sent;
        fwrite(pins, 1, 5, out);
        fwrite(&longest, 2, 1, out);
        fwrite(&least, 2, 1, out);
        fwrite(&resets, 4, 1, out);
        fwrite(&size, 2, 1, out);
        fwrite(sent, 1, size, out);
        fflush(out);
    }
}
