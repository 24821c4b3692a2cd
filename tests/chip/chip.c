/* The arm's firmware in a simulated ATmega328P (simavr), with two motors, encoders, links and home switches.
 *
 * As a shared library: tests drive it by ctypes, in its own time. With -DSERVE, as a program: it serves its serial
 * line on a pseudo-terminal by the clock, and takes from its standard input, a line each: reset | reverse J | hold J |
 * ask. Each is answered with both links and both motors in degrees, and the chip's own time in seconds: on a busy
 * computer that is behind the clock.
 */
#define _GNU_SOURCE
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <sim_avr.h>
#include <sim_cycle_timers.h>
#include <sim_elf.h>
#include <sim_time.h>

#include <avr_ioport.h>
#include <avr_uart.h>

#define STEP_US 50
#define BYTE_US 87
#define STICTION 1.15
#define RADIANS (3.14159265358979 / 180)
#define NUMBERS 14 /* of a motor */
#define ALL (2 * NUMBERS + 5)
enum { PORTB_AT = 0x25, PORTD_AT = 0x2B, OCR1A_AT = 0x88, OCR1B_AT = 0x8A };

typedef struct {
    double k, dead_band[2], tau, backlash, supply, counts, home, low, high, cam; /* the motor, its switch, its end stops */
    double kappa, gear_loss, most_v;                                        /* N·m a volt; R times the most current */
    double speed, position, link, acceleration;                             /* degrees; the last in rad/s² */
    long edge;
    int reversed, held, cut, skipped; /* cut: the second wire of its encoder is off; skipped: edges that it left out */
} motor_t;

typedef struct {
    avr_t *avr;
    avr_irq_t *encoder[4], *home[2], *rx;
    motor_t motors[2];
    double weights[2], inertias[3]; /* of the links: see Plant in stereo_lab/arm/virtual/plant.py */
    int full;
    uint8_t in[8192], out[65536];
    unsigned in_head, in_tail, out_head, out_tail;
} chip_t;

static const uint8_t GRAY[4] = {0, 1, 3, 2};

static void on_byte_out(struct avr_irq_t *irq, uint32_t value, void *param) {
    chip_t *chip = param;
    unsigned next = (chip->out_head + 1) % sizeof chip->out;
    if (next != chip->out_tail) {
        chip->out[chip->out_head] = value;
        chip->out_head = next;
    }
}

static void on_xon(struct avr_irq_t *irq, uint32_t value, void *param) { ((chip_t *)param)->full = 0; }
static void on_xoff(struct avr_irq_t *irq, uint32_t value, void *param) { ((chip_t *)param)->full = 1; }

static avr_cycle_count_t feed(avr_t *avr, avr_cycle_count_t when, void *param) {
    chip_t *chip = param;
    if (chip->in_tail != chip->in_head && !chip->full) {
        uint8_t byte = chip->in[chip->in_tail];
        chip->in_tail = (chip->in_tail + 1) % sizeof chip->in;
        avr_raise_irq(chip->rx, byte);
    }
    return when + avr_usec_to_cycles(avr, BYTE_US);
}

static double within(double value, double low, double high) { return value < low ? low : value > high ? high : value; }

static void turn(motor_t *m, double volts, int let_go, double load, double inertia, double dt) {
    double own = m->speed / m->k, pull = load / m->kappa, before = m->speed;
    double push = pull + (let_go ? 0 : within(volts, own - m->most_v, own + m->most_v));
    double way = m->speed > 0 || (m->speed == 0 && push > 0) ? 1 : -1;
    double rubs = m->dead_band[way < 0] + m->gear_loss * fabs(pull);
    m->acceleration = 0;
    if (m->held || (m->speed == 0 && fabs(push) <= STICTION * rubs)) {
        m->speed = 0;
        return;
    }
    double tau = m->tau * (1 + inertia / (m->kappa * m->tau / (m->k * RADIANS)));
    m->speed += (m->k * (push - way * rubs) - (let_go ? 0 : m->speed)) / tau * dt;
    if (m->speed * way < 0) m->speed = 0;
    m->position += (before + m->speed) / 2 * dt;
    if (m->position < m->low || m->position > m->high) {
        m->position = m->position < m->low ? m->low : m->high;
        m->speed = 0;
    }
    m->acceleration = (m->speed - before) / dt * RADIANS;
    double half = m->backlash / 2;
    if (m->position - m->link > half) m->link = m->position - half;
    if (m->link - m->position > half) m->link = m->position + half;
}

/* What hangs on the joints: the torque on each from outside, and the inertia that it carries. */
static void loads(const chip_t *chip, double *load, double *inertia) {
    const motor_t *one = &chip->motors[0], *other = &chip->motors[1];
    double upper = one->link * RADIANS, bend = other->link * RADIANS, w1 = one->speed * RADIANS, w2 = other->speed * RADIANS;
    double across = chip->inertias[2] * cos(bend), swing = chip->inertias[2] * sin(bend);
    double coupled = chip->inertias[1] + across, hangs = chip->weights[1] * cos(upper + bend);
    load[0] = swing * w2 * (2 * w1 + w2) - coupled * other->acceleration - chip->weights[0] * cos(upper) - hangs;
    load[1] = -swing * w1 * w1 - coupled * one->acceleration - hangs;
    inertia[0] = chip->inertias[0] + chip->inertias[1] + 2 * across;
    inertia[1] = chip->inertias[1];
}

static uint8_t encoder_lines(const motor_t *m) { return GRAY[((m->reversed ? -m->edge : m->edge) + m->skipped) & 3]; }

static void show(chip_t *chip, int j) {
    motor_t *m = &chip->motors[j];
    long edge = (long)floor(m->position * m->counts / 360);
    while (m->edge != edge) {
        m->edge += edge > m->edge ? 1 : -1;
        uint8_t lines = encoder_lines(m);
        avr_raise_irq(chip->encoder[2 * j], lines & 1);
        if (!m->cut) avr_raise_irq(chip->encoder[2 * j + 1], lines >> 1);
    }
    double beyond = m->home - m->link; /* the cam holds the switch closed, once in a turn; then it pulls its line down */
    avr_raise_irq(chip->home[j], beyond - 360 * floor(beyond / 360) > m->cam);
}

static avr_cycle_count_t plant(avr_t *avr, avr_cycle_count_t when, void *param) {
    chip_t *chip = param;
    uint8_t b = avr->data[PORTB_AT], d = avr->data[PORTD_AT];
    int way[2] = {!!(d & 0x40) - !!(d & 0x80), !!(b & 0x08) - !!(b & 0x10)}; /* both lines high: the brake */
    uint8_t duty[2] = {avr->data[OCR1A_AT], avr->data[OCR1B_AT]};
    double load[2], inertia[2];
    loads(chip, load, inertia);
    for (int j = 0; j < 2; j++) {
        double volts = chip->motors[j].supply * duty[j] / 255 * way[j];
        turn(&chip->motors[j], volts, !(b & 1), load[j], inertia[j], STEP_US * 1e-6); /* standby low: no current */
        show(chip, j);
    }
    return when + avr_usec_to_cycles(avr, STEP_US);
}

chip_t *chip_new(const char *elf) {
    elf_firmware_t firmware;
    memset(&firmware, 0, sizeof firmware);
    if (elf_read_firmware(elf, &firmware)) return NULL;
    strcpy(firmware.mmcu, "atmega328p");
    firmware.frequency = 16000000;
    chip_t *chip = calloc(1, sizeof *chip);
    avr_t *avr = chip->avr = avr_make_mcu_by_name(firmware.mmcu);
    avr_init(avr);
    avr->log = 1;
    avr_load_firmware(avr, &firmware);
    for (int k = 0; k < 4; k++) chip->encoder[k] = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('C'), k);
    for (int j = 0; j < 2; j++) chip->home[j] = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), 2 + j);
    uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
    flags &= ~(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    chip->rx = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_byte_out, chip);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON), on_xon, chip);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF), on_xoff, chip);
    avr_cycle_timer_register_usec(avr, STEP_US, plant, chip);
    avr_cycle_timer_register_usec(avr, BYTE_US, feed, chip);
    return chip;
}

/* k, dead band ccw and cw, tau, backlash, supply, counts, switch, end stops, kappa, gear loss, R times most current, cam */
void chip_motor(chip_t *chip, int j, const double *numbers) {
    motor_t *m = &chip->motors[j];
    memset(m, 0, sizeof *m);
    m->k = numbers[0], m->dead_band[0] = numbers[1], m->dead_band[1] = numbers[2], m->tau = numbers[3];
    m->backlash = numbers[4], m->supply = numbers[5], m->counts = numbers[6];
    m->home = numbers[7], m->low = numbers[8], m->high = numbers[9];
    m->kappa = numbers[10], m->gear_loss = numbers[11], m->most_v = numbers[12];
    m->cam = numbers[13];
    m->position = 180 / m->counts; /* in the middle of a count */
    show(chip, j);
}

/* weights of shoulder and elbow, N·m, and the three parts of the inertia, kg·m² */
void chip_arm(chip_t *chip, const double *numbers) {
    memcpy(chip->weights, numbers, sizeof chip->weights);
    memcpy(chip->inertias, numbers + 2, sizeof chip->inertias);
}

/* A reset clears the pins, but not what stands on the lines; simavr passes on only what changes. */
static void refresh(avr_irq_t *irq) {
    uint32_t value = irq->value;
    avr_raise_irq(irq, !value);
    avr_raise_irq(irq, value);
}

void chip_reset(chip_t *chip) {
    chip->in_head = chip->in_tail = chip->out_head = chip->out_tail = chip->full = 0;
    avr_reset(chip->avr);
    unsigned lines = 0;
    for (int j = 0; j < 2; j++) lines |= encoder_lines(&chip->motors[j]) << 2 * j;
    for (int k = 0; k < 4; k++) {
        avr_raise_irq(chip->encoder[k], lines >> k & 1);
        refresh(chip->encoder[k]);
    }
    avr_ioport_external_t outside = {.name = 'C', .mask = 0x0F, .value = lines}; /* stronger than pull-ups */
    avr_ioctl(chip->avr, AVR_IOCTL_IOPORT_SET_EXTERNAL('C'), &outside);
    for (int j = 0; j < 2; j++) refresh(chip->home[j]);
    avr_cycle_timer_cancel(chip->avr, plant, chip);
    avr_cycle_timer_cancel(chip->avr, feed, chip);
    avr_cycle_timer_register_usec(chip->avr, STEP_US, plant, chip);
    avr_cycle_timer_register_usec(chip->avr, BYTE_US, feed, chip);
}

static void skip_sleep(avr_t *avr, avr_cycle_count_t cycles) {}

int chip_run_us(chip_t *chip, unsigned us) {
    chip->avr->sleep = skip_sleep;
    avr_cycle_count_t end = chip->avr->cycle + avr_usec_to_cycles(chip->avr, us);
    while (chip->avr->cycle < end) {
        int state = avr_run(chip->avr);
        if (state == cpu_Done || state == cpu_Crashed) return state;
    }
    return 0;
}

int chip_write(chip_t *chip, const uint8_t *bytes, int n) {
    for (int i = 0; i < n; i++) {
        unsigned next = (chip->in_head + 1) % sizeof chip->in;
        if (next == chip->in_tail) return i;
        chip->in[chip->in_head] = bytes[i];
        chip->in_head = next;
    }
    return n;
}

int chip_read(chip_t *chip, uint8_t *bytes, int n) {
    int i = 0;
    while (i < n && chip->out_tail != chip->out_head) {
        bytes[i++] = chip->out[chip->out_tail];
        chip->out_tail = (chip->out_tail + 1) % sizeof chip->out;
    }
    return i;
}

int chip_waiting(chip_t *chip) { return (chip->out_head - chip->out_tail + sizeof chip->out) % sizeof chip->out; }
double chip_seconds(chip_t *chip) { return chip->avr->cycle / 16e6; }
double chip_link(chip_t *chip, int j) { return chip->motors[j].link; }
double chip_position(chip_t *chip, int j) { return chip->motors[j].position; }

void chip_fault(chip_t *chip, const char *name, int j) {
    if (!strcmp(name, "reverse")) chip->motors[j].reversed = 1;
    if (!strcmp(name, "hold")) chip->motors[j].held = 1;
    if (!strcmp(name, "cut")) chip->motors[j].cut = 1;
    if (!strcmp(name, "skip")) { /* two edges at once: the chip sees that one was missed */
        motor_t *m = &chip->motors[j];
        m->skipped += 2;
        uint8_t lines = encoder_lines(m);
        for (int k = 0; k < 2; k++) avr_raise_irq(chip->encoder[2 * j + k], lines >> k & 1);
    }
}

#ifdef SERVE
#include <fcntl.h>
#include <pty.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static double numbers[ALL];

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + t.tv_nsec * 1e-9;
}

static void motors(chip_t *chip) {
    for (int j = 0; j < 2; j++) chip_motor(chip, j, numbers + j * NUMBERS);
    chip_arm(chip, numbers + 2 * NUMBERS);
}

int main(int argc, char **argv) {
    if (argc != 2 + ALL) return 2;
    chip_t *chip = chip_new(argv[1]);
    if (!chip) return 1;
    for (int k = 0; k < ALL; k++) numbers[k] = atof(argv[2 + k]);
    motors(chip);
    int line, other;
    char name[64], order[128];
    struct termios raw;
    memset(&raw, 0, sizeof raw);
    cfmakeraw(&raw);
    openpty(&line, &other, name, &raw, NULL);
    printf("%s\n", name);
    fflush(stdout);
    fcntl(line, F_SETFL, O_NONBLOCK);
    fcntl(0, F_SETFL, O_NONBLOCK);
    double start = now() - chip_seconds(chip);
    for (;;) {
        uint8_t bytes[512];
        ssize_t n = read(line, bytes, sizeof bytes);
        if (n > 0) chip_write(chip, bytes, n);
        ssize_t said = read(0, order, sizeof order - 1);
        if (said == 0) return 0; /* nobody needs us any more */
        if (said > 0) {
            order[said] = 0;
            if (!strncmp(order, "reset", 5)) {
                while (read(line, bytes, sizeof bytes) > 0) {
                }
                motors(chip);
                chip_reset(chip);
                start = now() - chip_seconds(chip);
            } else if (!strncmp(order, "reverse", 7) || !strncmp(order, "hold", 4)) {
                chip_fault(chip, order[0] == 'r' ? "reverse" : "hold", atoi(strchr(order, ' ')) - 1);
            }
            printf("%.4f %.4f ", chip_link(chip, 0), chip_link(chip, 1));
            printf("%.4f %.4f %.4f\n", chip_position(chip, 0), chip_position(chip, 1), chip_seconds(chip));
            fflush(stdout);
        }
        if (chip_run_us(chip, 1000)) return 3;
        n = chip_read(chip, bytes, sizeof bytes);
        if (n > 0 && write(line, bytes, n) != n) return 4;
        double ahead = chip_seconds(chip) - (now() - start);
        if (ahead > 0.0005) usleep(ahead * 1e6);
    }
}
#endif
