#include "clock.h"

#include <avr/interrupt.h>
#include <util/atomic.h>

#include "board.h"

#define TICKS_PER_MILLISECOND 2000U // 16 MHz through a prescaler of 8

static volatile uint32_t milliseconds;

ISR(TIMER1_COMPA_vect) { milliseconds++; }

void clock_start(void) {
    TCCR1A = 0;
    OCR1A = TICKS_PER_MILLISECOND - 1;
    TIMSK1 = _BV(OCIE1A);
    TCCR1B = _BV(WGM12) | _BV(CS11);
}

uint32_t clock_milliseconds(void) {
    uint32_t now;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { now = milliseconds; }
    return now;
}

uint32_t clock_microseconds(void) {
    uint32_t whole;
    uint16_t ticks;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        whole = milliseconds;
        ticks = TCNT1;
        if ((TIFR1 & _BV(OCF1A)) && ticks < TICKS_PER_MILLISECOND / 2) whole++; // wrapped, interrupt still pending
    }
    return whole * 1000UL + ticks / 2;
}
