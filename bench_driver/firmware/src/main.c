// Firmware of the thruster bench: text at 9600 baud or frames at 115200 baud, whichever the host speaks.
//
// After a reset the device listens for text. Bytes that no text has, while no count came for a second, make it listen
// for frames for 300 ms; the first valid one in that time begins a framed session, which ends when none came for a
// second.
#include <avr/interrupt.h>
#include <avr/sleep.h>
#include <avr/wdt.h>

#include "board.h"
#include "clock.h"
#include "frames.h"
#include "input.h"
#include "output.h"
#include "text.h"
#include "timing.h"
#include "uart.h"

#define TEXT_BAUD 9600
#define FRAMED_BAUD 115200
#define MOST_AT_ONCE 32 // bytes between two ticks; a millisecond brings twelve

static uint8_t reset_cause __attribute__((section(".noinit")));

// Before anything else: after a watchdog reset the watchdog still runs, at its shortest time.
void keep_reset_cause(void) __attribute__((naked, used, section(".init3")));
void keep_reset_cause(void) {
    reset_cause = MCUSR;
    MCUSR = 0;
    wdt_disable();
}

enum mode { TEXT, PROBING, FRAMES };
static enum mode mode;
static uint32_t since;

static void speak_text(uint32_t now) {
    mode = TEXT;
    uart_open(TEXT_BAUD);
    text_start(now);
}

static void probe(uint32_t now) {
    mode = PROBING;
    since = now;
    uart_open(FRAMED_BAUD);
    frames_start(reset_cause);
}

static void receive(uint16_t byte, uint32_t now) {
    if (mode == TEXT) {
        if (!text_receive(byte, now)) probe(now);
    } else {
        frames_receive(byte, now);
        if (frames_session(now)) mode = FRAMES;
    }
}

static void tick(uint32_t now) {
    switch (mode) {
    case TEXT: text_tick(now); break;
    case PROBING:
        if (now - since >= PROBE_MS) speak_text(now);
        break;
    case FRAMES:
        if (frames_session(now)) {
            frames_tick(now);
        } else {
            output_disable();
            speak_text(now);
        }
    }
}

int main(void) {
    output_start(); // first of all
    wdt_enable(WDTO_120MS);
    input_start();
    clock_start();
    set_sleep_mode(SLEEP_MODE_IDLE);
    sei();
    speak_text(0);
    for (;;) {
        uint16_t byte;
        for (uint8_t n = 0; n < MOST_AT_ONCE && uart_read(&byte); n++) receive(byte, clock_milliseconds());
        tick(clock_milliseconds());
        wdt_reset();
        sleep_mode(); // until the next byte or the next millisecond
    }
}
