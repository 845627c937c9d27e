// The serial port to the host, UART 0 behind the USB bridge; interrupt driven, never blocks.
#ifndef UART_H
#define UART_H

#include <stdbool.h>
#include <stdint.h>

#define UART_DAMAGED 0x100 // set in a received byte that came with a framing error

void uart_open(uint32_t baud); // also forgets what was waiting to be read or sent
bool uart_read(uint16_t *byte);
void uart_write(const uint8_t *data, uint8_t length); // all of it or, if there is no room, nothing
uint16_t uart_overruns(void); // received bytes lost since the last uart_open

#endif
