/* Functions that PushbeltVariator exports in addition to those of FMI 2.0. C and C++.
 *
 * Load them from the FMU's library (binaries/...) by name, like those of the standard. They take an instance of
 * fmi2Instantiate. No other call may use the instance at the same time.
 *
 * SPDX-License-Identifier: MIT OR Apache-2.0
 */
#ifndef PUSHBELT_H
#define PUSHBELT_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The linear model dx/dt = A x + B u, y = C x + D u about the present state of an instance, as JSON (RFC 8259, UTF-8).
 *
 * instance   an fmi2Component in initialization mode or later. Its state does not change.
 * frequency  modes below this become states, Hz; 0.01 to 1e5.
 * json       set to a string that ends with a zero, or to NULL. Free it by pushbeltFreeText.
 *
 * Returns an fmi2Status:
 *   fmi2OK (0)       the linear model is about the point of the parameters and inputs;
 *   fmi2Warning (1)  there is a model, but the belt slips through, or the point is held by other loads than the given ones:
 *                    see "remarks" in the JSON and the log;
 *   fmi2Error (3)    there is no model, for example because the state is not steady. The log has the reason; the instance
 *                    can still be used.
 *
 * The object has: A, B, C, D (arrays of rows); inputs (name, unit, given, held); outputs (name, unit, value); states (names);
 * poles (real and imaginary part, 1/s); slip (1); macroSlip (true or false); remarks (sentences); frequency, time. x, u and y are
 * deviations from the point, SI units; the inputs "held" are those at which the point is steady.
 */
typedef int pushbeltLinearizeTYPE(void *instance, double frequency, char **json);
int pushbeltLinearize(void *instance, double frequency, char **json);

/* The derivatives of all real outputs of a steady start with respect to real parameters and inputs, as JSON.
 *
 * instance   an fmi2Component in initialization mode, or after it before the first step. Its state does not change.
 * vr, nvr    value references of the parameters and inputs, and how many.
 * json       as of pushbeltLinearize.
 *
 * Returns an fmi2Status: fmi2OK, or fmi2Error if there is no gradient, for example because the start is not steady, the belt slips
 * through, or a variable is not real. The log has the reason; the instance can still be used.
 *
 * The object has: outputs and variables (name, unit, value); gradient (a row for each output, a column for each variable, SI units; null
 * for extremes along the belt, idle arcs, and the efficiency without power); held ("ratio" or "clamping forces": what the changed
 * starts keep).
 */
typedef int pushbeltGradientTYPE(void *instance, const unsigned int vr[], size_t nvr, char **json);
int pushbeltGradient(void *instance, const unsigned int vr[], size_t nvr, char **json);

/* Resets an instance as fmi2Reset does. The next steady start (initial.steady) begins its search at the steady state that the run
 * before started from: where the two differ by some per cent, it takes a tenth of the work. The same state is found, within 1e-5.
 * If it is not near enough, it is sought as after fmi2Reset.
 *
 * Returns an fmi2Status, as fmi2Reset.
 */
typedef int pushbeltResetNearTYPE(void *instance);
int pushbeltResetNear(void *instance);

/* Frees a string of pushbeltLinearize or pushbeltGradient; NULL is legal. */
typedef void pushbeltFreeTextTYPE(char *text);
void pushbeltFreeText(char *text);

#ifdef __cplusplus
}
#endif

#endif
