// Runs the firmware's ELF on an emulated ATmega2560 with its converters, in lockstep with whoever writes the requests.
//
// Usage: emulator FIRMWARE.elf. One request a line on standard input, one answer a line on standard output:
//
//   advance MICROSECONDS LINE_SPEED COUNTS BYTES     COUNTS: 16 comma-separated ADC counts; BYTES: hexadecimal or -
//     -> CODES ENABLED BYTES                         CODES: 8 converters, -1 = high impedance; ENABLED: hexadecimal bits
//   reset                                            pulls the reset line
//     -> ok
//
// The host's bytes arrive one after the other at the host's line speed; at another speed than the processor's own,
// either side sees bytes FF. An answer that begins with "failed" is the last one.
#define _GNU_SOURCE
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <simavr/avr_adc.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_spi.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_cycle_timers.h>
#include <simavr/sim_elf.h>

#include "mcp4921.h"

enum { CLOCK = 16000000, MILLIVOLTS = 5000, INPUTS = 16, CONVERTERS = 8, MOST_BYTES = 1 << 16, BITS_PER_BYTE = 10 };
enum { DDRA = 0x21, PORTA = 0x22, UCSR0A = 0xC0, U2X0 = 1 << 1, UBRR0L = 0xC4, UBRR0H = 0xC5, GARBLED = 0xFF };
enum { ADCSRB = 0x7B, MUX5 = 1 << 3, MUX_OF_INPUT_8 = 32 };
enum { SPEED_TOLERANCE_PERCENT = 4 };

static avr_t *avr;
static avr_irq_t *line_in;
static struct mcp4921 converters[CONVERTERS];
static unsigned line_speed = 9600;
static unsigned millivolts[INPUTS];
static uint8_t arriving[MOST_BYTES], sent[MOST_BYTES];
static size_t arriving_first, arriving_count, sent_count;
static avr_cycle_count_t next_byte, target;

static bool speeds_agree(void) {
    unsigned divider = (avr->data[UBRR0L] | avr->data[UBRR0H] << 8) + 1;
    double own = (double)CLOCK / (avr->data[UCSR0A] & U2X0 ? 8 : 16) / divider;
    double off = own / line_speed - 1;
    return (off < 0 ? -off : off) * 100 < SPEED_TOLERANCE_PERCENT;
}

static avr_cycle_count_t byte_time(void) { return (avr_cycle_count_t)CLOCK * BITS_PER_BYTE / line_speed; }

static avr_cycle_count_t on_byte_due(avr_t *core, avr_cycle_count_t when, void *param) {
    (void)core, (void)param;
    if (!arriving_count) return 0;
    uint8_t byte = arriving[arriving_first];
    arriving_first = (arriving_first + 1) % MOST_BYTES;
    arriving_count--;
    avr_raise_irq(line_in, speeds_agree() ? byte : GARBLED);
    next_byte = when + byte_time();
    return arriving_count ? next_byte : 0;
}

// A processor that sleeps jumps to its next timer: without this one, beyond the end of the period.
static avr_cycle_count_t on_target(avr_t *core, avr_cycle_count_t when, void *param) {
    (void)core, (void)when, (void)param;
    return 0;
}

// A reset forgets all timers.
static void keep_timers(void) {
    if (!avr_cycle_timer_status(avr, on_target, NULL) && avr->cycle < target)
        avr_cycle_timer_register(avr, target - avr->cycle, on_target, NULL);
    if (arriving_count && !avr_cycle_timer_status(avr, on_byte_due, NULL))
        avr_cycle_timer_register(avr, next_byte > avr->cycle ? next_byte - avr->cycle : 1, on_byte_due, NULL);
}

static void on_sent(struct avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)param;
    if (sent_count < MOST_BYTES) sent[sent_count++] = speeds_agree() ? value : GARBLED;
}

static void on_select(struct avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq;
    mcp4921_select(param, !value);
}

static void on_spi(struct avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)param;
    for (int i = 0; i < CONVERTERS; i++) mcp4921_byte(&converters[i], value);
}

// simavr 1.6 keeps eight voltages only: each conversion gets the one of its input, 8 to 15 through 0 to 7.
static void on_conversion(struct avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)param;
    union { avr_adc_mux_t mux; uint32_t value; } started = {.value = value};
    unsigned low = started.mux.src & 7, input = low | (avr->data[ADCSRB] & MUX5 ? 8 : 0);
    avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0 + low), millivolts[input]);
}

static void share_voltages(void) {
    for (avr_io_t *io = avr->io_port; io; io = io->next)
        if (!strcmp(io->kind, "adc"))
            for (int i = 0; i < 8; i++) ((avr_adc_t *)io)->muxmode[MUX_OF_INPUT_8 + i].src = i;
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_OUT_TRIGGER), on_conversion, NULL);
}

static void no_sleep(avr_t *core, avr_cycle_count_t cycles) { (void)core, (void)cycles; } // time is the requests'

static void log_to_stderr(avr_t *core, const int level, const char *format, va_list arguments) {
    (void)core;
    if (level <= LOG_ERROR) vfprintf(stderr, format, arguments);
}

static bool start(const char *file) {
    elf_firmware_t firmware = {0};
    avr_global_logger_set(log_to_stderr);
    if (elf_read_firmware(file, &firmware)) return false;
    strcpy(firmware.mmcu, "atmega2560");
    firmware.frequency = CLOCK;
    avr = avr_make_mcu_by_name(firmware.mmcu);
    if (!avr || avr_init(avr)) return false;
    avr_load_firmware(avr, &firmware);
    avr->sleep = no_sleep;
    avr->avcc = avr->vcc = avr->aref = MILLIVOLTS;
    uint32_t flags = 0; // neither lines on the console nor naps while polling
    avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
    flags &= ~(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    line_in = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_sent, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_SPI_GETIRQ(0), SPI_IRQ_OUTPUT), on_spi, NULL);
    share_voltages();
    for (int i = 0; i < CONVERTERS; i++) {
        mcp4921_power_on(&converters[i]);
        avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('C'), i), on_select, &converters[i]);
    }
    return true;
}

static bool read_inputs(char *counts) {
    char *rest = NULL, *one = strtok_r(counts, ",", &rest);
    for (int i = 0; i < INPUTS; i++, one = strtok_r(NULL, ",", &rest)) {
        int count = one ? atoi(one) : -1;
        if (count < 0 || count > 1023) return false;
        // The smallest whole number of millivolts that converts to this count: simavr gives mV·1023/5000.
        millivolts[i] = (count * MILLIVOLTS + 1022) / 1023;
    }
    return one == NULL;
}

static bool read_bytes(const char *digits) {
    if (!strcmp(digits, "-")) return true;
    if (!arriving_count) next_byte = (next_byte > avr->cycle ? next_byte : avr->cycle + byte_time());
    for (unsigned value; *digits; digits += 2) {
        if (arriving_count == MOST_BYTES || sscanf(digits, "%2x", &value) != 1) return false;
        arriving[(arriving_first + arriving_count++) % MOST_BYTES] = value;
    }
    return true;
}

static void answer(void) {
    for (int i = 0; i < CONVERTERS; i++) printf("%s%d", i ? "," : "", converters[i].code);
    printf(" %02x ", avr->data[PORTA] & avr->data[DDRA]);
    if (!sent_count) putchar('-');
    for (size_t i = 0; i < sent_count; i++) printf("%02x", sent[i]);
    putchar('\n');
    sent_count = 0;
}

static const char *advance(char *request) {
    static char counts[256], bytes[2 * MOST_BYTES + 2];
    unsigned microseconds;
    if (sscanf(request, "advance %u %u %255s %131073s", &microseconds, &line_speed, counts, bytes) != 4 || !line_speed)
        return "request not understood";
    if (!read_inputs(counts)) return "expected 16 counts from 0 to 1023";
    if (!read_bytes(bytes)) return "too many bytes, or not hexadecimal";
    avr_cycle_timer_cancel(avr, on_target, NULL);
    target += (avr_cycle_count_t)microseconds * (CLOCK / 1000000);
    while (avr->cycle < target) {
        keep_timers();
        int state = avr_run(avr);
        if (state == cpu_Done || state == cpu_Crashed) return "the processor has stopped";
    }
    answer();
    return NULL;
}

int main(int argc, char **argv) {
    if (argc != 2 || !start(argv[1])) {
        fprintf(stderr, "usage: %s FIRMWARE.elf, compiled for the ATmega2560\n", argv[0]);
        return 2;
    }
    char *request = NULL;
    size_t size = 0;
    while (getline(&request, &size, stdin) > 0) {
        const char *failure = NULL;
        if (!strncmp(request, "reset", 5)) {
            avr_reset(avr);
            puts("ok");
        } else {
            failure = advance(request);
        }
        if (failure) printf("failed: %s\n", failure);
        fflush(stdout);
        if (failure) return 1;
    }
    free(request);
    return 0;
}
