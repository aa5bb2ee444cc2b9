"""A controller around the variator: read, compute, write, step. Name the FMU, or run it where `target/PushbeltVariator.fmu` is."""

import ctypes
import math
import shutil
import sys

import fmpy
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.logging import addLoggerProxy

FMU = sys.argv[1] if len(sys.argv) == 2 else "target/PushbeltVariator.fmu"
description, folder = fmpy.read_model_description(FMU), fmpy.extract(FMU)
reference = {variable.name: variable.valueReference for variable in description.modelVariables}
model = description.coSimulation.modelIdentifier
unit = FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier=model, instanceName="variator")

inputs = ["primary.torque", "secondary.torque", "primary.clampingForce", "secondary.clampingForce"]
outputs = ["primary.speed", "secondary.speed", "ratio.geometric", "primary.radius", "thrustRatio", "slip"]
START = {"secondary.inertia": 4.0, "initial.ratio": 1.6, "initial.primarySpeed": 200.0, "primary.torque": 60.0,
         "secondary.torque": -90.0, "secondary.clampingForce": 16e3}  # fmt: skip

callbacks = fmi2CallbackFunctions()  # the unit's messages go to standard error; fmpy's own logger mixes them with the results
callbacks.logger = fmi2CallbackLoggerTYPE(lambda _a, _b, _c, _d, text: print(text.decode(), file=sys.stderr))
addLoggerProxy(ctypes.byref(callbacks))

unit.instantiate(callbacks=callbacks)
unit.setupExperiment(startTime=0.0)
unit.setReal([reference[name] for name in START], list(START.values()))
unit.enterInitializationMode()
unit.exitInitializationMode()

step, target, integral = 0.01, 0.8, 0.0
holding = unit.getReal([reference["thrustRatio"]])[0]  # thrust ratio of the steady start
of_maps = reference.get("map.holdingThrustRatio")  # only the unit of maps has one at each time
for k in range(300):
    state = dict(zip(outputs, unit.getReal([reference[name] for name in outputs]), strict=True))
    if of_maps is not None:
        holding, integral = unit.getReal([of_maps])[0], 0.0
    torque, load = 60.0, -60.0 - 0.2 * state["secondary.speed"]
    secondary = 1.3 * torque * math.cos(math.radians(11)) / (2 * 0.09 * state["primary.radius"])
    error = math.log(state["ratio.geometric"] / target)  # above 0: shift to overdrive, the primary force must rise
    demand = secondary * (holding + 2.0 * error + integral)
    primary = min(max(demand, 2e3), 60e3)
    integral += step * (3.0 * error + (primary - demand) / secondary / 0.1)  # anti-windup by back-calculation
    unit.setReal([reference[name] for name in inputs], [torque, load, primary, secondary])
    unit.doStep(currentCommunicationPoint=k * step, communicationStepSize=step)
    if k % 50 == 0:
        print("t %.1f s  " % (k * step) + "  ".join(f"{name} {value:.4g}" for name, value in state.items()))

unit.terminate()
unit.freeInstance()
shutil.rmtree(folder)
print(f"ratio {state['ratio.geometric']:.3f}, target {target}")
