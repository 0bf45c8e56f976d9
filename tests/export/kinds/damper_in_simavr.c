/* Runs a program on a simulated ATmega328P at 16 MHz until it stops. GPIOR0 = 1 begins a step of the damper and 2 ends it; what is
 * written to GPIOR1 is printed. Prints one line a step: its cycles, the bytes of stack below its caller, the bytes written. */
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_io.h>
#include <stdio.h>
#include <string.h>

#define GPIOR0 0x3E
#define GPIOR1 0x4A
#define SPL 0x5D

static avr_cycle_count_t begun, took;
static unsigned top, lowest;
static int running;

static unsigned stack_pointer(avr_t *avr) { return avr->data[SPL] | (unsigned)avr->data[SPL + 1] << 8; }

static void mark(avr_t *avr, avr_io_addr_t address, uint8_t value, void *unused)
{
    (void)address; (void)unused;
    if (value == 1) { begun = avr->cycle; top = lowest = stack_pointer(avr); running = 1; }
    if (value == 2) { took = avr->cycle - begun; running = 0; printf("%u %u", (unsigned)took, top - lowest); }
    if (value == 3) printf("\n");
}

static void byte(avr_t *avr, avr_io_addr_t address, uint8_t value, void *unused)
{
    (void)avr; (void)address; (void)unused;
    printf(" %u", value);
}

int main(int argc, char **argv)
{
    elf_firmware_t firmware;
    avr_t *avr = avr_make_mcu_by_name("atmega328p");
    memset(&firmware, 0, sizeof firmware);
    if (argc != 2 || !avr || elf_read_firmware(argv[1], &firmware)) return 2;
    avr_init(avr);
    avr->frequency = 16000000;
    avr_load_firmware(avr, &firmware);
    avr_register_io_write(avr, GPIOR0, mark, NULL);
    avr_register_io_write(avr, GPIOR1, byte, NULL);
    for (;;) {
        int state = avr_run(avr);
        if (running && stack_pointer(avr) < lowest) lowest = stack_pointer(avr);
        if (state == cpu_Done || state == cpu_Crashed) return state == cpu_Crashed;
    }
}
