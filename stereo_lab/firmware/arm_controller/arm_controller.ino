/* The arm's controller: two DC gear motors with encoders and home switches, behind a serial line.
 *
 * For an Arduino Uno or Nano (ATmega328P, 16 MHz). Open it in the Arduino IDE and upload it as it is; it needs no
 * library. Parts, wiring and what to check before power: README.md one folder up. The protocol: PROTOCOL.md there.
 * The rules by which it moves stand in Python in stereo_lab/motion/rules.py, the same controller in Python in
 * stereo_lab/arm/virtual/controller.py: the names are the same.
 *
 *   joint 1   PWM D9    IN1 D6    IN2 D7     encoder A0, A1   switch D2
 *   joint 2   PWM D10   IN1 D11   IN2 D12    encoder A2, A3   switch D3       driver's standby D8
 *
 * The encoders have port C to themselves: every change of it is an edge.
 */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

const float TICK_S = 0.002, TICKS_A_SECOND = 500;  // the controller looks and acts 500 times a second
const uint8_t TICK_MS = 2;
const float ARRIVED_COUNTS = 0.6;
const uint8_t REST_TICKS = 6;
const float LAG_DEG = 10, KICK_V = 0.02, KEPT = 0.5, MOST_LOAD_V = 2;
const float RUNAWAY_DEG = 0.6, WRONG_COUNTS = 2.5;
const float FOLLOW_DEG = 20, STALL_V = 1.5, CREEPS_DEG_S = 10;
const uint16_t STALL_TICKS = 250, STUCK_TICKS = 50, HELD_TICKS = 125, COAST_TICKS = 250;
const float ROLLS = 3;  // by the rule: braked, a motor rolls on by tau times its speed; with an arm 3 times as far
const float NET_COUNTS = 1.5, OWED_DEG = 5, OWED_COUNTS = 8;  // a lone line of an encoder goes to and fro by one count
const uint8_t OWED_TICKS = 20;
const uint8_t CLOSED_TICKS = 3, BRAKE_TICKS = 125;
const float SEEK_DEG = 400, SEEK_DEG_S = 60, BACK_DEG = 8, CREEP_DEG_S = 10, HOME_ACC = 1000;
const uint8_t BACK_TRIES = 6;
const uint8_t LINE_MAX = 63;

enum Mode : uint8_t { IDLE, HOLD, MOVE, PUSH, SEEK, BACK, CREEP, REST };
enum Code : uint8_t { FINE, CHECKSUM, COMMAND, ARGUMENT, LIMIT, OFF, TOO_LONG, OVERRUN, BUSY };
const char *const ERRORS[] = {"", "checksum", "command", "argument", "limit", "off", "too long", "overrun", "busy"};

struct Joint {
  // parameters, in the order of PARAMETERS below
  float lo, hi, home, cruise, acc, k, tau, db[2], st[2], zone, counts, supply, g[2];
  // what follows from them: divisions are slow, and a tick has two milliseconds
  float kp, ki, per_k, tau_per_k, volts_of_duty, duty_of_volts, arrived, most_to_start;
  // where it stands
  volatile int32_t edges;
  volatile uint16_t lost;
  volatile uint8_t lines;
  int32_t count, zero_count, closed_count;
  float zero_deg, position, speed, degree;
  bool homed;
  // what it does
  Mode mode;
  int16_t duty;
  float rested_v, obeyed, wrong;  // its voltage at rest before this began; turned since with what was added, and against
  float weight, load, push;  // volts: what holds the arm's weight, a load besides, and a push on top of both
  uint16_t still, strained, push_ticks, idles;
  uint8_t tries, closed;
  bool pushed;
  // the plan of a move
  float planned, plan_speed, speeding_up, goal, left, plan_cruise, plan_acc, kick, way, fast_v, slow_v;
  float mark, owed;  // by the rule: where it last was for certain, and how far its voltage should have turned it since
  uint8_t rests;
  int8_t turned;  // which way the last edge went
};

struct Parameter {
  char name[7];
  uint8_t at;
  float low, high;
};
#define AT(field) offsetof(Joint, field)
const Parameter PARAMETERS[] = {
    {"lo", AT(lo), -360, 360},     {"hi", AT(hi), -360, 360},   {"home", AT(home), -360, 360},
    {"cruise", AT(cruise), 1, 720}, {"acc", AT(acc), 10, 4000}, {"k", AT(k), 10, 2000},
    {"tau", AT(tau), 5, 1000},     {"db+", AT(db), 0, 24},      {"db-", AT(db) + sizeof(float), 0, 24},
    {"st+", AT(st), 0, 24},        {"st-", AT(st) + sizeof(float), 0, 24},
    {"zone", AT(zone), 0, 180},    {"counts", AT(counts), 16, 65535}, {"supply", AT(supply), 1, 24},
    {"g1", AT(g), -24, 24},        {"g2", AT(g) + sizeof(float), -24, 24},
};

Joint joints[2];
bool enabled, stopped, by_rule, checksums;
char fault = '-', fault_joint;
uint16_t watchdog_ms = 1000, report_ms, dropped;
uint32_t now_ms, heard_ms, reported_ms;
volatile uint8_t tick_due;

// The serial line: own buffers, so that a full line never holds up the motors for long.

volatile uint8_t rx[64], rx_head, rx_tail, rx_lost, tx[128], tx_head, tx_tail;
volatile uint8_t stop_asked, line_start = 1;
const uint8_t STOP_LOST = 2;  // in rx_lost: what was lost held a stop
uint16_t crc;

ISR(USART_RX_vect) {
  uint8_t byte = UDR0, next = (rx_head + 1) & 63;
  bool stop = byte == '!' && line_start;
  if (stop) stop_asked = 1;
  line_start = byte == '\n' || byte == '\r' || (line_start && (byte == '!' || byte == '?'));
  if (rx_lost || next == rx_tail) {  // once a byte is lost, what follows waits for loop() to know of it
    if (rx_lost != STOP_LOST) rx_lost = stop ? STOP_LOST : 1;
  } else {
    rx[rx_head] = byte;
    rx_head = next;
  }
}

ISR(USART_UDRE_vect) {
  if (tx_head == tx_tail) {
    UCSR0B &= ~_BV(UDRIE0);
  } else {
    UDR0 = tx[tx_tail];
    tx_tail = (tx_tail + 1) & 127;
  }
}

const uint8_t STATUS_BYTES = 100, ANSWER_BYTES = 60;  // no status and no other answer is longer

bool room_for(uint8_t bytes) { return ((tx_head - tx_tail) & 127) < 128 - bytes; }

uint16_t crc_add(uint16_t value, uint8_t byte) {  // CRC-16/CCITT-FALSE
  value ^= (uint16_t)byte << 8;
  for (uint8_t bit = 0; bit < 8; bit++) value = value & 0x8000 ? (value << 1) ^ 0x1021 : value << 1;
  return value;
}

void put(char c) {
  uint8_t next = (tx_head + 1) & 127;
  while (next == tx_tail) {
  }
  tx[tx_head] = c;
  tx_head = next;
  UCSR0B |= _BV(UDRIE0);
  crc = crc_add(crc, c);
}

void say(const char *text) {
  while (*text) put(*text++);
}

void say_number(int32_t value) {
  char digits[12];
  say(ltoa(value, digits, 10));
}

void say_decimal(float value, uint8_t places) {
  int32_t scale = 1;
  for (uint8_t k = 0; k < places; k++) scale *= 10;
  int32_t scaled = lround(fabs(value) * scale);
  if (value < 0 && scaled) put('-');
  say_number(scaled / scale);
  put('.');
  for (scale /= 10; scale; scale /= 10) put('0' + scaled / scale % 10);
}

void begin_line() { crc = 0xFFFF; }

void end_line() {
  if (checksums) {
    uint16_t value = crc;
    put('*');
    for (int8_t shift = 12; shift >= 0; shift -= 4) put("0123456789ABCDEF"[value >> shift & 15]);
  }
  put('\r');
  put('\n');
}

void event(const char *name, int8_t j) {
  begin_line();
  put('!');
  say(name);
  if (j >= 0) {
    put(' ');
    say_number(j + 1);
    put(' ');
    say_decimal(joints[j].position, 2);
  }
  end_line();
}

bool homing(const Joint &joint) { return joint.mode >= SEEK; }

bool busy(const Joint &joint) { return joint.mode > HOLD; }

bool beside(const Joint &joint) {  // held, and moved off its place
  return joint.mode == HOLD && fabs(joint.goal - joint.position) > joint.arrived;
}

uint16_t lost_of(Joint &joint) {  // two bytes, which an edge must not change in between
  cli();
  uint16_t lost = joint.lost;
  sei();
  return lost;
}

void say_status() {
  begin_line();
  if (stopped) say("<stop");
  else if (!enabled) say("<off");
  else if (homing(joints[0]) || homing(joints[1])) say("<home");
  else if (busy(joints[0]) || busy(joints[1]) || beside(joints[0]) || beside(joints[1])) say("<run");
  else say("<idle");
  say(" t=");
  say_number(now_ms & 0x7FFFFFFF);
  say(" h=");
  say_number(joints[0].homed + 2 * joints[1].homed);
  say(" f=");
  put(fault);
  if (fault == 's' || fault == 'r') put(fault_joint);
  say(" p=");
  say_decimal(joints[0].position, 2);
  put(',');
  say_decimal(joints[1].position, 2);
  say(" v=");
  say_number(lround(joints[0].speed));
  put(',');
  say_number(lround(joints[1].speed));
  say(" lost=");
  say_number((uint32_t)lost_of(joints[0]) + lost_of(joints[1]));  // an int has 16 bits here
  say(" drop=");
  say_number(dropped);
  put('>');
  end_line();
}

// Encoders, motors, switches.

const int8_t EDGE[16] = {0, 1, -1, 2, -1, 0, 2, 1, 1, 2, 0, -1, 2, -1, 1, 0};  // 2: an edge was missed

static inline void count_edge(Joint &joint, uint8_t lines) {
  int8_t edge = EDGE[joint.lines << 2 | lines];
  joint.lines = lines;
  if (edge == 2) joint.lost++;
  else joint.edges += edge;
}

ISR(PCINT1_vect) {
  uint8_t port = PINC;
  count_edge(joints[0], port & 3);
  count_edge(joints[1], port >> 2 & 3);
}

ISR(TIMER2_COMPA_vect) { tick_due = 1; }

int32_t counts_of(Joint &joint) {
  cli();
  int32_t edges = joint.edges;
  sei();
  return edges;
}

bool closed_now(uint8_t j) { return !(PIND & (j ? _BV(PD3) : _BV(PD2))); }

bool pressed(uint8_t j) { return joints[j].closed >= CLOSED_TICKS; }  // a glitch on its wire is no switch

void set_duty(uint8_t j, int16_t duty) {
  joints[j].duty = duty;
  bool forward = duty >= 0, backward = duty <= 0;  // both: the motor is short-circuited, which brakes it
  cli();
  if (j == 0) {
    PORTD = (PORTD & ~(_BV(PD6) | _BV(PD7))) | (forward ? _BV(PD6) : 0) | (backward ? _BV(PD7) : 0);
    OCR1A = abs(duty);
  } else {
    PORTB = (PORTB & ~(_BV(PB3) | _BV(PB4))) | (forward ? _BV(PB3) : 0) | (backward ? _BV(PB4) : 0);
    OCR1B = abs(duty);
  }
  sei();
}

void brake_or_let_go() {  // off, a motor that turns is braked; when both have rested for a while, no current flows
  if (!enabled && joints[0].still >= BRAKE_TICKS && joints[1].still >= BRAKE_TICKS) PORTB &= ~_BV(PB0);
  else PORTB |= _BV(PB0);
}

void set_volts(uint8_t j, float volts) {
  float duty = volts * joints[j].duty_of_volts;
  set_duty(j, lround(duty > 255 ? 255 : duty < -255 ? -255 : duty));
}

void retune(Joint &joint) {  // after a change of its parameters
  float tau = joint.tau / 1000;
  joint.per_k = 1 / joint.k;
  joint.tau_per_k = tau / joint.k;
  joint.kp = 2 / (joint.k * tau);
  joint.ki = joint.kp / (4 * tau) * TICK_S;
  joint.volts_of_duty = joint.supply / 255;
  joint.duty_of_volts = 255 / joint.supply;
  joint.degree = 360 / joint.counts;
  joint.arrived = ARRIVED_COUNTS * joint.degree;
  joint.most_to_start = (joint.st[0] > joint.st[1] ? joint.st[0] : joint.st[1]) + STALL_V;
}

void stand_at(Joint &joint, float angle) {
  joint.count = joint.zero_count = counts_of(joint);
  joint.zero_deg = joint.position = angle;
}

float held(const Joint &joint) { return joint.weight + joint.load; }  // what holds it in its pose

bool may_hold() { return enabled && !stopped && fault == '-' && !by_rule; }  // in the paper's way nothing is held

void halt(bool latch, char why, char which, bool hold = false) {  // braked, or held against the arm's weight, if the motors are on
  for (uint8_t j = 0; j < 2; j++) {
    if (joints[j].mode != IDLE) joints[j].idles = 0;
    joints[j].mode = IDLE;
    set_volts(j, hold && may_hold() ? held(joints[j]) : 0);
  }
  stopped |= latch;
  if (why) {
    fault = why;
    fault_joint = which;
  }
}

void finish(uint8_t j, const char *name) {
  joints[j].mode = joints[j].mode == MOVE && !by_rule ? HOLD : IDLE;
  set_volts(j, by_rule ? 0 : held(joints[j]));
  event(name, j);
}

void stall(uint8_t j) {
  halt(false, 's', '1' + j);
  event("stall", j);
}

// Ways to move (stereo_lab/motion/rules.py).

void plan_from_rest(Joint &joint) {
  joint.planned = joint.position;
  joint.plan_speed = joint.speeding_up = joint.kick = 0;
  joint.rests = 0;
}

// The way that is left is what the plan counts down: a float has seven digits, and a slow plan far from zero would
// add less than the last of them to its place, and never end. Not inlined: avr-gcc 5.4 spoils a register there.
__attribute__((noinline)) void plan_to(Joint &joint, float goal, float cruise, float acceleration) {
  joint.goal = goal;
  joint.left = goal - joint.planned;
  joint.plan_cruise = cruise;
  joint.plan_acc = acceleration;
}

void trapezoid_step(Joint &joint) {
  float left = joint.left, way = left >= 0 ? 1 : -1;
  float change = joint.plan_acc * TICK_S;
  float in_time = sqrt(change * change * 0.25f + 2 * joint.plan_acc * fabs(left)) - change * 0.5f;
  float faster = joint.plan_speed * way + change, slower = joint.plan_speed * way - change;
  float speed = in_time < joint.plan_cruise ? in_time : joint.plan_cruise;
  speed = speed > faster ? faster : speed < slower ? slower : speed;
  if (fabs(left) <= fabs(speed) * TICK_S && fabs(speed) <= 2 * change) {
    joint.planned = joint.goal;
    joint.left = joint.plan_speed = 0;
  } else {
    joint.left -= way * speed * TICK_S;
    joint.planned = joint.goal - joint.left;
    joint.plan_speed = way * speed;
  }
}

float kick_volts(Joint &joint, float error) {
  joint.kick += KICK_V;
  float starts = joint.st[error < 0] + joint.kick, asks = joint.kp * fabs(error);
  if (starts < asks) starts = asks;
  return held(joint) + (error > 0 ? starts : -starts);
}

void add_load(Joint &joint, float volts) {  // never more than a motor may hold
  joint.load += volts;
  joint.load = joint.load > MOST_LOAD_V ? MOST_LOAD_V : joint.load < -MOST_LOAD_V ? -MOST_LOAD_V : joint.load;
}

void learn(Joint &joint, float error) {  // what the error, and a kick that has just ended, tell of the load
  add_load(joint, joint.ki * error + (error > 0 ? KEPT : error < 0 ? -KEPT : 0) * joint.kick);
  joint.kick = 0;
}

float profile_volts(Joint &joint, bool *done) {
  float before = joint.plan_speed, lag = joint.planned - joint.position;
  if (before == 0 || (before > 0 ? lag : -lag) < LAG_DEG) trapezoid_step(joint);  // else the plan waits
  float there = joint.left;
  if (there * joint.plan_speed >= 0 && (joint.goal - joint.position) * there <= 0) {
    joint.planned = joint.goal;  // ahead of its plan, or at its end
    joint.left = joint.plan_speed = 0;
  }
  joint.speeding_up = (joint.plan_speed - before) * TICKS_A_SECOND;
  float error = joint.planned - joint.position;
  bool ended = joint.left == 0 && joint.plan_speed == 0;
  if (ended && fabs(error) <= joint.arrived) {
    *done = joint.rests >= REST_TICKS;
    joint.kick = 0;
    return held(joint);
  }
  if (joint.rests >= REST_TICKS && (ended || error * joint.plan_speed > 0)) return kick_volts(joint, error);
  learn(joint, error);
  float feedback = joint.kp * error + held(joint);
  if (ended && error * joint.turned <= 0) return feedback;
  if (ended) return feedback + (error > 0 ? joint.db[0] : -joint.db[1]);  // lest friction is learned as a load
  float friction = joint.plan_speed > 0 ? joint.db[0] : -joint.db[1];
  return friction + joint.plan_speed * joint.per_k + joint.speeding_up * joint.tau_per_k + feedback;
}

bool rolls_beyond(const Joint &joint) {  // its limit, if it is not braked now
  float room = joint.way > 0 ? joint.hi - joint.position : joint.position - joint.lo;
  return room < ROLLS * joint.tau * 0.001f * joint.speed * joint.way;
}

float rule_volts(Joint &joint, bool *done) {
  float left = (joint.goal - joint.position) * joint.way;
  *done = left <= 0 && joint.rests >= REST_TICKS;
  if (left <= 0 || rolls_beyond(joint)) return 0;
  return joint.way * (left > joint.zone ? joint.fast_v : joint.slow_v);
}

bool overloaded(const Joint &joint) { return fabs(joint.load) >= MOST_LOAD_V; }

bool owes_much(Joint &joint) {  // by the rule: its voltage should have turned it by far more than its edges tell
  if (fabs(joint.position - joint.mark) > NET_COUNTS * joint.degree) {
    joint.mark = joint.position;
    joint.owed = joint.strained = 0;
  }
  float free_v = joint.way * (joint.duty * joint.volts_of_duty - joint.weight) - joint.db[joint.way < 0];
  joint.owed += joint.k * free_v * TICK_S;
  if (joint.owed < 0) joint.owed = 0;
  joint.strained++;
  bool much = joint.owed > OWED_DEG + OWED_COUNTS * joint.degree && joint.strained > OWED_TICKS;
  return much && joint.still == 0;  // without an edge, STALL_TICKS tell
}

bool stalls(Joint &joint, float volts) {
  if (by_rule && joint.mode == MOVE) {
    bool no_edge = joint.still > STALL_TICKS && volts != 0;
    return owes_much(joint) || no_edge || (joint.planned - joint.position) * joint.way > FOLLOW_DEG;
  }
  float push = volts - joint.weight;
  bool turns = (push > 0 ? joint.speed : -joint.speed) > CREEPS_DEG_S;
  float beside = fabs(joint.planned - joint.position);
  bool strained = fabs(push) > joint.most_to_start || (overloaded(joint) && beside > joint.arrived);
  joint.strained = strained && !turns ? joint.strained + 1 : 0;
  return beside > FOLLOW_DEG || joint.strained > STUCK_TICKS;
}

// The control loop.

void look(Joint &joint) {
  int32_t count = counts_of(joint);
  int32_t turned = count - joint.count;
  joint.count = count;
  joint.position = joint.zero_deg + (count - joint.zero_count) * joint.degree;
  joint.speed += 0.1f * (turned * joint.degree * TICKS_A_SECOND - joint.speed);
  if (turned == 0) {
    if (joint.still < 65535) joint.still++;
    if (joint.rests < 255) joint.rests++;
    return;
  }
  joint.still = joint.rests = 0;
  joint.turned = turned > 0 ? 1 : -1;
  float added = joint.duty * joint.volts_of_duty - joint.rested_v, way = turned * joint.degree;
  float left = joint.mode == PUSH || by_rule ? 0 : joint.goal - joint.position;
  if (way * added > 0 || way * left > 0) joint.obeyed += fabs(way);  // with its voltage, or where it should
  else if (fabs(added) > 2 * joint.db[added < 0]) joint.wrong += fabs(way);
}

bool runs_away(const Joint &joint) {  // from rest against what was added to the voltage under which it rested
  float most = WRONG_COUNTS * joint.degree;
  if (most < RUNAWAY_DEG) most = RUNAWAY_DEG;
  return joint.wrong > most && joint.obeyed < most;
}

void weigh() {  // what holds the arm in this pose, where both joints know where they stand
  const float RADIANS = M_PI / 180;
  bool known = joints[0].homed && joints[1].homed;
  float one = known ? cos(joints[0].position * RADIANS) : 0;
  float both = known ? cos((joints[0].position + joints[1].position) * RADIANS) : 0;
  for (uint8_t j = 0; j < 2; j++) joints[j].weight = joints[j].g[0] * one + joints[j].g[1] * both;
}

void keep_holding() {  // the angles are other ones now, or what is known of the weight; what holds the joints goes on
  float before[2] = {held(joints[0]), held(joints[1])};
  weigh();
  for (uint8_t j = 0; j < 2; j++) {
    joints[j].load = 0;
    add_load(joints[j], before[j] - joints[j].weight);
    if (joints[j].mode == HOLD) joints[j].mode = IDLE;  // held anew, where it stands
  }
}

void back_off(Joint &joint) {
  joint.tries++;
  if (joint.mode != SEEK) plan_from_rest(joint);
  joint.mode = BACK;
  plan_to(joint, joint.position + BACK_DEG, SEEK_DEG_S, HOME_ACC);
}

void keep_homing(uint8_t j, Joint &joint) {
  bool closed = pressed(j), done = false;
  if (joint.mode == REST) {
    if (joint.still >= REST_TICKS) {
      joint.homed = true;
      finish(j, "home");
      keep_holding();
    }
    return;
  }
  if (joint.mode == SEEK && closed) {
    back_off(joint);
  } else if (joint.mode == CREEP && closed) {
    set_volts(j, held(joint));
    joint.zero_count = joint.closed_count;
    joint.zero_deg = joint.home;
    joint.position = joint.home + (joint.count - joint.zero_count) * joint.degree;
    joint.mode = REST;
    joint.still = 0;
    return;
  }
  float volts = profile_volts(joint, &done);
  if (done && joint.mode == BACK && !closed) {
    joint.mode = CREEP;
    plan_from_rest(joint);
    plan_to(joint, joint.position - (2 + joint.tries) * BACK_DEG, CREEP_DEG_S, HOME_ACC);
  } else if (done && joint.mode == BACK && joint.tries < BACK_TRIES) {
    back_off(joint);
  } else if (done || stalls(joint, volts)) {
    stall(j);
  } else {
    set_volts(j, volts);
  }
}

void hold(Joint &joint) {  // where it stands
  joint.mode = HOLD;
  joint.strained = 0;
  plan_from_rest(joint);
  plan_to(joint, joint.position, 0, 0);
}

void keep_pushing(uint8_t j, Joint &joint) {
  if (joint.push_ticks) joint.push_ticks--;
  if ((joint.push > 0 && joint.position > joint.hi) || (joint.push < 0 && joint.position < joint.lo)) finish(j, "limit");
  else if (joint.still > HELD_TICKS && fabs(joint.push) > joint.most_to_start) stall(j);
  else if (joint.push_ticks == 0 && joint.pushed) set_volts(j, held(joint)), joint.pushed = false, joint.still = 0;
  else if (joint.push_ticks == 0 && joint.still >= REST_TICKS) finish(j, "done");
  else if (joint.push_ticks == 0 && ++joint.idles > COAST_TICKS) finish(j, "done");  // a load carries it on
}

void follow(uint8_t j, Joint &joint) {
  bool done = false;
  float volts = by_rule ? rule_volts(joint, &done) : profile_volts(joint, &done);
  if (done && joint.mode == MOVE) finish(j, "done");
  else if (stalls(joint, volts)) stall(j);
  else set_volts(j, volts);
}

void look_at(uint8_t j) {
  Joint &joint = joints[j];
  look(joint);
  if (!closed_now(j)) joint.closed = 0;
  else if (!joint.closed++) joint.closed_count = joint.count;  // the place counts, if it proves to be no glitch
  else if (joint.closed > CLOSED_TICKS) joint.closed = CLOSED_TICKS;
}

void weigh_at_times() {  // a cosine takes its time
  static uint8_t ticks;
  if (!(++ticks & 7)) weigh();
}

void hold_if_it_rests(Joint &joint) {  // or after a while
  if (joint.idles < 65535) joint.idles++;
  if (!may_hold()) return;
  if (joint.still >= REST_TICKS || joint.idles > COAST_TICKS) hold(joint);
}

void control(uint8_t j) {
  Joint &joint = joints[j];
  if (joint.mode == IDLE) hold_if_it_rests(joint);
  if (joint.mode == IDLE) return;
  if (busy(joint) && runs_away(joint)) {
    halt(true, 'r', '1' + j);
    event("runaway", j);
  } else if (joint.mode <= MOVE) {
    follow(j, joint);
  } else if (joint.mode == PUSH) {
    keep_pushing(j, joint);
  } else {
    keep_homing(j, joint);
  }
}

void tick() {
  now_ms += TICK_MS;
  for (uint8_t j = 0; j < 2; j++) look_at(j);
  brake_or_let_go();
  weigh_at_times();
  for (uint8_t j = 0; j < 2; j++) control(j);
  if (watchdog_ms && (busy(joints[0]) || busy(joints[1])) && now_ms - heard_ms > watchdog_ms) {
    halt(false, 'w', 0);
    enabled = false;
    event("watchdog", -1);
  }
  if (report_ms && now_ms - reported_ms >= report_ms) {
    reported_ms = now_ms;
    if (room_for(STATUS_BYTES)) say_status();
    else dropped++;
  }
}

// Commands.

char line[LINE_MAX + 1], data[28];
uint8_t length, args;
char *arg[7];
bool asked, too_long, spoiled;  // spoiled: there are bytes in the line that are no characters
bool skipping;                  // over what is left of a line of which bytes were lost
int16_t number, last_number = -1;
Code last_code;
char last_data[28];

bool read_number(const char *text, float low, float high, float *value, Code *code) {
  const char *c = text;
  uint8_t whole = 0, part = 0;
  if (*c == '-') c++;
  for (; *c >= '0' && *c <= '9'; c++) whole++;
  if (*c == '.') {
    for (c++; *c >= '0' && *c <= '9'; c++) part++;
    if (!part || part > 6) whole = 0;
  }
  if (*c || !whole || whole > 7) {
    *code = ARGUMENT;
    return false;
  }
  *value = atof(text);
  if (*value >= low && *value <= high) return true;
  *code = LIMIT;
  return false;
}

void begin_move(Joint &joint, Mode mode) {
  if (joint.mode != mode) {  // a new goal on the way does not clear what was seen so far
    joint.rested_v = joint.duty * joint.volts_of_duty;
    joint.wrong = joint.kick = 0;
    joint.obeyed = joint.still < REST_TICKS ? 1e6 : 0;  // what carries it on may be a load
    joint.still = joint.strained = 0;
    joint.mark = joint.position;
    joint.owed = 0;
  }
  joint.mode = mode;
  fault = '-';
}

float duration(const Joint &joint, float goal) {
  float way = fabs(goal - joint.position);
  if (way < joint.cruise * joint.cruise / joint.acc) return 2 * sqrt(way / joint.acc);
  return way / joint.cruise + joint.cruise / joint.acc;
}

Code move_to(uint8_t which, const float *goals, float pace) {  // which: bit 0 and bit 1 for the joints
  float times[2], longest = 0;
  for (uint8_t j = 0; j < 2; j++)
    if (which >> j & 1 && !(goals[j] >= joints[j].lo && goals[j] <= joints[j].hi)) return LIMIT;
  if (stopped || !enabled) return OFF;
  for (uint8_t j = 0; j < 2; j++) {
    if (!(which >> j & 1)) continue;
    if (busy(joints[j]) && (by_rule || joints[j].mode != MOVE)) return BUSY;
    times[j] = duration(joints[j], goals[j]);
    if (times[j] > longest) longest = times[j];
  }
  for (uint8_t j = 0; j < 2; j++) {
    if (!(which >> j & 1)) continue;
    Joint &joint = joints[j];
    float share = pace * (times[j] == 0 ? 1 : times[j] / longest), acceleration = joint.acc;
    if (joint.mode != MOVE) {
      acceleration *= share * share;  // a joint that moves already needs all of it, to brake in time
      plan_from_rest(joint);
    }
    plan_to(joint, goals[j], joint.cruise * share, acceleration);
    joint.way = goals[j] >= joint.position ? 1 : -1;
    uint8_t side = joint.way < 0;
    joint.slow_v = joint.st[side];
    joint.fast_v = joint.db[side] + joint.cruise * pace / joint.k;
    if (joint.fast_v < joint.slow_v) joint.fast_v = joint.slow_v;  // a slow move has to start as well
    begin_move(joint, MOVE);
  }
  return FINE;
}

bool flag(const char *text, bool *on) {
  *on = text[0] == '1';
  return (text[0] == '0' || text[0] == '1') && !text[1];
}

void write_number(float value) {  // three digits behind the point, into the data of the reply
  int32_t scaled = lround(fabs(value) * 1000);
  char *end = data;
  if (value < 0 && scaled) *end++ = '-';
  ltoa(scaled / 1000, end, 10);
  end += strlen(end);
  *end++ = '.';
  *end++ = '0' + scaled / 100 % 10;
  *end++ = '0' + scaled / 10 % 10;
  *end++ = '0' + scaled % 10;
  *end = 0;
}

Code execute() {
  Code code = FINE;
  float value = 0, other = 0;
  bool on;
  const char *name = arg[0];
  uint8_t given = args - 1;
  auto is = [&](const char *wanted, uint8_t least, uint8_t most) {
    if (strcmp(name, wanted)) return false;
    if (given < least || given > most) code = ARGUMENT;
    return true;
  };

  if (is("ID", 0, 0)) {
    if (!code) strcpy(data, "armkit 1 joints=2 hz=500");
    return code;
  }
  if (is("ST", 0, 0)) {
    if (!code) halt(false, 0, 0, true);
    return code;
  }
  if (is("EN", 1, 1)) {
    if (code || !flag(arg[1], &on)) return ARGUMENT;
    if (!on) halt(false, 0, 0);
    else if (!enabled || stopped || fault != '-') joints[0].idles = joints[1].idles = 0;
    if (on) fault = '-';
    stopped = false;
    enabled = on;
    return FINE;
  }
  if (is("CS", 1, 1)) {
    if (code || !flag(arg[1], &on)) return ARGUMENT;
    checksums = on;
    return FINE;
  }
  if (is("MODE", 1, 1)) {
    bool rule = given == 1 && !strcmp(arg[1], "rule");
    if (code || (!rule && strcmp(arg[1], "pid"))) return ARGUMENT;
    if (busy(joints[0]) || busy(joints[1])) return BUSY;
    by_rule = rule;
    halt(false, 0, 0, true);
    return FINE;
  }
  if (is("RP", 1, 1)) {
    if (code || !read_number(arg[1], 0, 60000, &value, &code)) return code;
    if (value > 0 && value < 20) return LIMIT;
    report_ms = value;
    reported_ms = now_ms;  // first after that time
    return FINE;
  }
  if (is("WD", 1, 1)) {
    if (code || !read_number(arg[1], 0, 60000, &value, &code)) return code;
    if (value > 0 && value < 100) return LIMIT;
    watchdog_ms = value;
    return FINE;
  }
  if (is("MA", 2, 3)) {
    float goals[2], percent = 100;
    if (code || !read_number(arg[1], -1e6, 1e6, &goals[0], &code)) return code;
    if (!read_number(arg[2], -1e6, 1e6, &goals[1], &code)) return code;
    if (given == 3 && !read_number(arg[3], 1, 100, &percent, &code)) return code;
    return move_to(3, goals, percent / 100);
  }

  // what is left has a joint as its first argument
  bool mv = is("MV", 2, 3), pw = is("PW", 3, 3), ze = is("ZE", 1, 2), hm = is("HM", 1, 1);
  bool set = is("SET", 3, 3), get = is("GET", 2, 2);
  if (!(mv || pw || ze || hm || set || get)) return COMMAND;
  if (code) return code;
  if ((arg[1][0] != '1' && arg[1][0] != '2') || arg[1][1]) return ARGUMENT;
  uint8_t j = arg[1][0] - '1';
  Joint &joint = joints[j];

  if (mv) {
    float goals[2], percent = 100;
    if (!read_number(arg[2], -1e6, 1e6, &goals[j], &code)) return code;
    if (given == 3 && !read_number(arg[3], 1, 100, &percent, &code)) return code;
    return move_to(1 << j, goals, percent / 100);
  }
  if (pw) {
    if (!read_number(arg[2], -255, 255, &value, &code) || !read_number(arg[3], 1, 2000, &other, &code)) return code;
    if (stopped || !enabled) return OFF;
    if (busy(joint)) return BUSY;
    joint.pushed = true;
    joint.idles = 0;
    joint.push_ticks = (uint16_t)(other / TICK_MS + 0.5f);
    if (!joint.push_ticks) joint.push_ticks = 1;
    begin_move(joint, PUSH);
    joint.push = (int16_t)value * joint.volts_of_duty - held(joint);  // what is beyond its weight
    set_duty(j, value);
    return FINE;
  }
  if (ze) {
    if (given == 2 && !read_number(arg[2], -360, 360, &value, &code)) return code;
    if (busy(joint)) return BUSY;
    stand_at(joint, value);
    joint.homed = true;
    keep_holding();
    return FINE;
  }
  if (hm) {
    if (stopped || !enabled) return OFF;
    if (busy(joint)) return BUSY;
    joint.tries = 0;
    joint.homed = false;
    keep_holding();
    begin_move(joint, SEEK);
    plan_from_rest(joint);
    plan_to(joint, joint.position - SEEK_DEG, SEEK_DEG_S, HOME_ACC);
    if (pressed(j)) back_off(joint);
    return FINE;
  }
  if (get && !strcmp(arg[2], "held")) {
    write_number(held(joint));
    return FINE;
  }
  for (const Parameter &parameter : PARAMETERS) {
    if (strcmp(arg[2], parameter.name)) continue;
    float *field = (float *)((char *)&joint + parameter.at);
    if (get) {
      write_number(*field);
      return FINE;
    }
    if (!read_number(arg[3], parameter.low, parameter.high, &value, &code)) return code;
    if (busy(joints[0]) || busy(joints[1])) return BUSY;
    *field = value;
    if (parameter.at == AT(counts)) stand_at(joint, joint.position);
    retune(joint);
    keep_holding();
    return FINE;
  }
  return ARGUMENT;
}

void answer(Code code, const char *text) {
  begin_line();
  say(code ? "err" : "ok");
  if (number >= 0) {
    say(" N");
    say_number(number);
  }
  if (code) {
    put(' ');
    say_number(code);
    put(' ');
    say(ERRORS[code]);
  } else if (*text) {
    put(' ');
    say(text);
  }
  end_line();
}

bool hex_is(const char *text, uint16_t value) {
  for (int8_t shift = 12; shift >= 0; shift -= 4)
    if (*text++ != "0123456789ABCDEF"[value >> shift & 15]) return false;
  return !*text;
}

void split_words(char *text) {  // words are parted by blanks
  args = 0;
  for (char *part = strtok(text, " \t"); part && args < 7; part = strtok(0, " \t")) arg[args++] = part;
}

bool take_number() {  // Nseq in front: N and one to four digits
  if (!args || arg[0][0] != 'N') return false;
  uint8_t digits = strlen(arg[0]) - 1;
  if (digits < 1 || digits > 4 || strspn(arg[0] + 1, "0123456789") != digits) return false;
  number = atoi(arg[0] + 1);
  args--;
  for (uint8_t k = 0; k < args; k++) arg[k] = arg[k + 1];
  return true;
}

void end_of_line() {
  line[length] = 0;
  uint8_t had = length;
  bool long_line = too_long, bad = spoiled;
  length = 0;
  too_long = spoiled = false;
  number = -1;
  if (long_line) return answer(TOO_LONG, "");
  if (!had) return;
  if (bad) return answer(CHECKSUM, "");
  char *star = strrchr(line, '*');
  if (star) {
    uint16_t value = 0xFFFF;
    for (char *c = line; c < star; c++) value = crc_add(value, *c);
    if (!hex_is(star + 1, value)) return answer(CHECKSUM, "");
    *star = 0;
  } else if (checksums && strspn(line, " \t") < had) {
    return answer(CHECKSUM, "");
  }
  split_words(line);
  bool numbered = take_number();
  if (!args) {
    if (numbered) answer(COMMAND, "");
    return;
  }
  heard_ms = now_ms;
  if (numbered && number == last_number) return answer(last_code, last_data);
  strupr(arg[0]);
  data[0] = 0;
  Code code = execute();
  last_number = number;
  last_code = code;
  strcpy(last_data, data);
  answer(code, data);
}

void receive(uint8_t byte) {
  if (skipping) {
    skipping = byte != '\n' && byte != '\r';
  } else if (!length && !too_long && byte == '!') {
    halt(true, 'e', 0);
  } else if (!length && !too_long && byte == '?') {
    heard_ms = now_ms;
    asked = true;
  } else if (byte == '\n' || byte == '\r') {
    end_of_line();
  } else if (length < LINE_MAX) {
    line[length++] = byte;
    if ((byte < ' ' || byte > '~') && byte != '\t') spoiled = true;
  } else {
    too_long = true;
  }
}

// Start.

void start_joint(Joint &joint, float range, float home) {
  joint.lo = -range;
  joint.hi = range;
  joint.home = home;
  joint.cruise = 180;
  joint.acc = 500;
  joint.k = 75;
  joint.tau = 60;
  joint.db[0] = 0.4;
  joint.db[1] = 0.55;
  joint.st[0] = 0.46;
  joint.st[1] = 0.65;
  joint.zone = 5;
  joint.counts = 4094.4;
  joint.supply = 6;
  joint.still = REST_TICKS;  // whatever it did before, nothing moves it now
  retune(joint);
}

void setup() {
  cli();
  DDRB = _BV(PB0) | _BV(PB1) | _BV(PB2) | _BV(PB3) | _BV(PB4);  // standby, PWM, PWM, IN1, IN2 of joint 2
  PORTB = 0;                                                     // standby low: motors off
  DDRD = _BV(PD1) | _BV(PD6) | _BV(PD7);                         // serial out, IN1, IN2 of joint 1
  PORTD = _BV(PD2) | _BV(PD3);                                   // pull-ups for the switches
  DDRC = 0;
  PORTC = 0x0F;                                                  // pull-ups for the encoders
  TCCR1A = _BV(COM1A1) | _BV(COM1B1) | _BV(WGM10);               // 8-bit phase-correct PWM at 31 kHz
  TCCR1B = _BV(CS10);
  TCCR2A = _BV(WGM21);                                           // 500 ticks a second
  TCCR2B = _BV(CS22) | _BV(CS20);
  OCR2A = 249;
  TIMSK2 = _BV(OCIE2A);
  UCSR0A = _BV(U2X0);                                            // 115200 baud
  UBRR0 = 16;
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
  PCMSK1 = 0x0F;                                                 // every edge of both encoders
  PCICR = _BV(PCIE1);
  start_joint(joints[0], 165, -170);
  start_joint(joints[1], 155, -160);
  joints[0].lines = PINC & 3;
  joints[1].lines = PINC >> 2 & 3;
  sei();
  set_duty(0, 0);
  set_duty(1, 0);
  begin_line();
  say("armkit 1 ready");
  end_line();
}

void loop() {  // the motors first: however much comes down the line, no tick is missed and no stop waits
  if (stop_asked) {
    stop_asked = 0;
    halt(true, 'e', 0);
    event("estop", -1);
  }
  if (tick_due) {
    tick_due = 0;
    tick();
  }
  if (asked && room_for(STATUS_BYTES)) {
    asked = false;
    say_status();
  }
  while (!stop_asked && !tick_due && !asked && rx_tail != rx_head && room_for(ANSWER_BYTES)) {
    uint8_t byte = rx[rx_tail];
    rx_tail = (rx_tail + 1) & 63;
    receive(byte);
  }
  if (rx_lost && rx_tail == rx_head) {  // all that came before the gap has been read
    if (rx_lost == STOP_LOST) halt(true, 'e', 0);  // once more: an EN 1 before it may have undone it
    rx_lost = 0;
    length = 0;
    too_long = spoiled = false;
    skipping = true;
    number = -1;
    answer(OVERRUN, "");
  }
  cli();  // nothing to do: sleep until the next interrupt
  bool waiting = asked ? !room_for(STATUS_BYTES) : rx_tail == rx_head || !room_for(ANSWER_BYTES);
  if (!tick_due && !stop_asked && waiting) {
    sleep_enable();
    sei();
    sleep_cpu();
    sleep_disable();
  }
  sei();
}
