#include "input.h"

#include "board.h"

void input_start(void) {
    DIDR0 = DIDR2 = 0xFF; // no digital inputs on A0 to A15
    ADCSRA = _BV(ADEN) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0); // 125 kHz
}

uint16_t input_count(uint8_t channel) {
    ADMUX = _BV(REFS0) | (channel & 7); // reference AVCC
    ADCSRB = channel & 8 ? _BV(MUX5) : 0;
    ADCSRA |= _BV(ADSC);
    while (ADCSRA & _BV(ADSC)) {} // ended by the hardware watchdog should the converter ever fail
    return ADC;
}
