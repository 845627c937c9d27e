// An MCP4921 converter on a simulated SPI: 16 bits while selected, taken over when deselected (LDAC tied low).
#ifndef MCP4921_H
#define MCP4921_H

#include <stdbool.h>
#include <stdint.h>

#define MCP4921_OFF (-1) // power-on state and shutdown: high impedance

struct mcp4921 {
    bool selected;
    unsigned bytes;
    uint32_t shifted;
    int code; // 0 to 4095 or MCP4921_OFF; kept through a reset of the processor
};

void mcp4921_power_on(struct mcp4921 *chip);
void mcp4921_select(struct mcp4921 *chip, bool selected);
void mcp4921_byte(struct mcp4921 *chip, uint8_t byte);

#endif
