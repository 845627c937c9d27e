#include "output.h"

#define ZERO_CODE (LARGEST_CODE / 2)
#define ZERO_COUNT 128
#define CODES_PER_COUNT 16
#define MCP4921_ACTIVE 0x3000 // unbuffered reference, gain 1, output on

static uint16_t codes[THRUSTERS];

static void spi_send(uint8_t byte) {
    SPDR = byte;
    while (!(SPSR & _BV(SPIF))) {}
    (void)SPDR;
}

static void set_code(uint8_t i, uint16_t code) {
    codes[i] = code;
    uint16_t word = MCP4921_ACTIVE | code;
    SELECT_PORT &= ~_BV(i);
    spi_send(word >> 8);
    spi_send(word & 0xFF);
    SELECT_PORT |= _BV(i); // LDAC is tied low: the code takes effect here
}

void output_start(void) {
    SELECT_PORT = 0xFF;
    SELECT_DDR = 0xFF;
    SPI_DDR |= SPI_PINS;
    SPCR = _BV(SPE) | _BV(MSTR) | _BV(SPR0); // 1 MHz, mode 0
    output_disable();
    ENABLE_DDR = 0xFF; // driven low from here on
}

void output_disable(void) {
    ENABLE_PORT = 0;
    for (uint8_t i = 0; i < THRUSTERS; i++) set_code(i, ZERO_CODE);
}

bool output_set_count(uint8_t count) {
    if (!(ENABLE_PORT & 1) && count != ZERO_COUNT) return false;
    set_code(0, count * CODES_PER_COUNT);
    ENABLE_PORT |= 1;
    return true;
}

void output_hold_zero_count(void) { set_code(0, ZERO_COUNT * CODES_PER_COUNT); }

bool output_set_millivolts(uint8_t i, bool enable, int16_t value) {
    bool enabled = ENABLE_PORT & _BV(i), refused = enable && !enabled && value != 0;
    if (!enable || refused) {
        ENABLE_PORT &= ~_BV(i);
        set_code(i, ZERO_CODE);
    } else {
        set_code(i, ((int32_t)(LARGEST_MILLIVOLTS - value) * 51 + 62) / 125);
        ENABLE_PORT |= _BV(i);
    }
    return !refused;
}

uint8_t output_enabled(void) { return ENABLE_PORT; }

uint16_t output_code(uint8_t i) { return codes[i]; }
