#include "uart.h"

#include <avr/interrupt.h>
#include <util/atomic.h>

#include "board.h"

// Rings of 256 bytes: their indices wrap by themselves.
static volatile uint8_t received[256], received_flags[32], received_head, received_tail;
static volatile uint8_t sending[256], sending_head, sending_tail;
static volatile uint16_t overruns;

ISR(USART0_RX_vect) {
    uint8_t status = UCSR0A, byte = UDR0, next = received_head + 1;
    if (status & _BV(DOR0)) overruns++;
    if (next == received_tail) {
        overruns++;
        return;
    }
    uint8_t bit = 1 << (received_head & 7);
    if (status & _BV(FE0))
        received_flags[received_head >> 3] |= bit;
    else
        received_flags[received_head >> 3] &= ~bit;
    received[received_head] = byte;
    received_head = next;
}

ISR(USART0_UDRE_vect) {
    if (sending_head == sending_tail)
        UCSR0B &= ~_BV(UDRIE0);
    else
        UDR0 = sending[sending_tail++];
}

void uart_open(uint32_t baud) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        UCSR0B = 0;
        received_head = received_tail = sending_head = sending_tail = 0;
        overruns = 0;
        UCSR0A = _BV(U2X0);
        UBRR0 = (F_CPU / 4 / baud - 1) / 2; // rounded to the nearest
        UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
        UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
    }
}

bool uart_read(uint16_t *byte) {
    uint8_t at = received_tail;
    if (at == received_head) return false;
    *byte = received[at];
    if (received_flags[at >> 3] & (1 << (at & 7))) *byte |= UART_DAMAGED;
    received_tail = at + 1;
    return true;
}

void uart_write(const uint8_t *data, uint8_t length) {
    uint8_t used = sending_head - sending_tail;
    if (length > 255 - used) return;
    while (length--) sending[sending_head++] = *data++;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { UCSR0B |= _BV(UDRIE0); }
}

uint16_t uart_overruns(void) {
    uint16_t count;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { count = overruns; }
    return count;
}
