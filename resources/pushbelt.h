/* What PushbeltVariator exports beside the functions of FMI 2.0. C and C++.
 *
 * Load both functions from the FMU's library (binaries/...) by name, as those of the standard. They work on an instance of
 * fmi2Instantiate. Nothing else may use the instance during a call.
 *
 * SPDX-License-Identifier: MIT OR Apache-2.0
 */
#ifndef PUSHBELT_H
#define PUSHBELT_H

#ifdef __cplusplus
extern "C" {
#endif

/* The linear model dx/dt = A x + B u, y = C x + D u about the state in which an instance is, as JSON (RFC 8259, UTF-8).
 *
 * instance   an fmi2Component in initialization mode or later. It stays as it is.
 * frequency  modes below this become states, Hz; 0.01 to 1e5.
 * json       set to a string that ends with a zero, or to NULL. Free it by pushbeltFreeText.
 *
 * Returns an fmi2Status:
 *   fmi2OK (0)       the point is the one that parameters and inputs give;
 *   fmi2Warning (1)  there is a model, but the belt slips through, or other loads hold the point than those that are given.
 *                    "remarks" in the JSON and the log say which;
 *   fmi2Error (3)    there is no model, because the state is not steady for instance. The log says why; the instance goes on.
 *
 * The object has: A, B, C, D (arrays of rows); inputs (name, unit, given, held); outputs (name, unit, value); states (names);
 * poles (real and imaginary part, 1/s); slip (1); macroSlip (true or false); remarks (sentences); frequency, time. x, u and y are
 * deviations from the point, SI units; the inputs "held" keep the point.
 */
typedef int pushbeltLinearizeTYPE(void *instance, double frequency, char **json);
int pushbeltLinearize(void *instance, double frequency, char **json);

/* Frees a string of pushbeltLinearize; NULL is legal. */
typedef void pushbeltFreeTextTYPE(char *text);
void pushbeltFreeText(char *text);

#ifdef __cplusplus
}
#endif

#endif
