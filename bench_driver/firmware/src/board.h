// What is connected to which pin of an Arduino Mega (ATmega2560, 16 MHz), and how many of it. See ../README.md.
#ifndef BOARD_H
#define BOARD_H

#define F_CPU 16000000UL

#include <avr/io.h>
#include <stdint.h>

#ifndef THRUSTERS
#define THRUSTERS 1
#endif
#ifndef LOADS
#define LOADS 6
#endif
#if THRUSTERS < 1 || THRUSTERS > 8
#error "THRUSTERS: expected 1 to 8"
#endif
#if LOADS < 0 || LOADS > 6 || LOADS > 8 - THRUSTERS
#error "LOADS: expected 0 to 6, and at most 8 - THRUSTERS: both share the inputs A8 to A15"
#endif

// Analogue inputs: tachometer i on A0+i, flow sensor i on A8+i, load channel j on A15-j.
#define TACHOMETER_INPUT(i) (i)
#define FLOW_INPUT(i) (8 + (i))
#define LOAD_INPUT(j) (15 - (j))

// Enable line of output i: D22+i = PA0+i, high = switched to the converter. A pull-down of 10 kOhm holds it low while
// the pin is an input, which it is during a reset and in the boot loader.
#define ENABLE_PORT PORTA
#define ENABLE_DDR DDRA

// Chip select of the MCP4921 of output i: D37-i = PC0+i, low = selected, pull-up of 10 kOhm.
#define SELECT_PORT PORTC
#define SELECT_DDR DDRC

// SPI: D52 = PB1 clock, D51 = PB2 data, D53 = PB0 the SS pin, which has to be an output for the SPI to stay master.
#define SPI_PORT PORTB
#define SPI_DDR DDRB
#define SPI_PINS (_BV(PB0) | _BV(PB1) | _BV(PB2))

#endif
