"""Command lines that are wrong, each with how the one sentence begins that says so: `command | sentence`."""

from __future__ import annotations

from typing import Final

WRONG_LINES: Final = r"""
evaluate | Missing from python -m agents.evaluate: --controller NAME|RU
evaluate analytic | Missing from python -m agents.evaluate: --controller NAME|RU
evaluate --controller | Missing value for argument '--controller'
evaluate --controller "" | '.' holds neither foreign.zip nor best_model.zip
evaluate --controller analytic --picks | Missing value for argument '--picks'
evaluate --controller analytic --picks "" | Error parsing --picks: no type matching {None}|INT could
evaluate --controller analytic --picks 0 | --picks is 0; it must be at least 1
evaluate --controller analytic --picks -5 | --picks is -5; it must be at least 1
evaluate --controller analytic --picks many | Error parsing --picks: no type matching {None}|INT could
evaluate --controller analytic --picks 1.5 | Error parsing --picks: no type matching {None}|INT could
evaluate --controller analytic --picks 1e3 | Error parsing --picks: no type matching {None}|INT could
evaluate --controller analytic --picks nan | Error parsing --picks: no type matching {None}|INT could
evaluate --controller analytic --picks 4 4 | Unrecognized options: 4
evaluate --controller analytic --picsk 4 | Unrecognized options: --picsk, 4; perhaps you meant --picks
evaluate --controller analytic --seed -1 | --seed is -1; it must be at least 0
evaluate --controller analytic --seed x | Error parsing --seed: invalid literal for int() with base 10
evaluate --controller analytic --num-envs 0 | --num-envs is 0; it must be at least 1
evaluate --controller analytic --num-envs -1 | --num-envs is -1; it must be at least 1
evaluate --controller analytic --num-envs 100001 | num_envs is 100001; it must be a whole number from 1 to 1000
evaluate --controller analytic --threads 0 | --threads is 0; it must be at least 1
evaluate --controller analytic --threads 1025 | threads is 1025; it must be a whole number from 1 to 1024
evaluate --controller analytic --practice -1 | --practice is -1; it must be at least 0
evaluate --controller analytic --practice x | Error parsing --practice: no type matching {None}|INT could
evaluate --controller analytic --online yes | Unrecognized options: yes
evaluate --controller analytic --level "" | unknown level ''; shipped levels are
evaluate --controller analytic --env "" | unknown environment ''; known are
evaluate --controller analytic --action-mode "" | action_mode is ''; it must be one of
evaluate --controller analytic --level Waste | unknown level 'Waste'; shipped levels are day, day_far, d
evaluate --controller analytic --level waste.yaml | level file 'waste.yaml' does not exist
evaluate --controller analytic --level folder | unknown level 'folder'; shipped levels are day, day_far,
evaluate --controller analytic --level text.yaml | level file 'text.yaml' must hold a mapping of settings, it h
evaluate --controller analytic --level typo.yaml | level file 'typo.yaml': unknown key 'binz'
evaluate --controller analytic --level circle.yaml | level file 'circle.yaml': levels are their own base: circle
evaluate --controller analytic --level heavy.yaml | level file 'heavy.yaml': suction.tau is 1000000000.0: input
evaluate --controller analytic --level day | level 'day' drifts, and nothing in this environment tells
evaluate --controller analytic --env PnTRelease-v0 --level day | level 'day' drifts, and nothing in t
evaluate --controller kalman | controller 'kalman' goes by what is told of the throw before; u
evaluate --controller kalman --env GripperToss-v0 | controller 'kalman' goes by what is told of the thro
evaluate --controller analytic --env PnTRelease | unknown environment 'PnTRelease'; known are PnTConveyor-v0,
evaluate --controller analytic --env pntrelease-v0 | unknown environment 'pntrelease-v0'; known are PnTConveyor-v
evaluate --controller analytic --env PnTRelease-v1 | unknown environment 'PnTRelease-v1'; known are PnTConveyor-v
evaluate --controller analytic --env nobody:Cell-v0 | module 'nobody' cannot be imported: ModuleNotFoundError: No
evaluate --controller analytic --env os:Cell-v0 | unknown environment 'Cell-v0': module 'os' does not register
evaluate --controller analytic --env : | unknown environment ''; known are PnTConveyor-v0, PnTAdapt
evaluate --controller analytic --env OneJointThrow-v0 --level waste | unknown level 'waste'; shipped levels are contac
evaluate --controller analytic --env OneJointThrow-v0 --action-mode release_point | action_mode is 'release_point'; it
evaluate --controller analytic --action-mode Release_Point | action_mode is 'Release_Point'; it must be one of release
evaluate --controller analytic --json "" | cannot write '.': it is a folder
evaluate --controller analytic --json folder | cannot write 'folder': it is a folder
evaluate --controller analytic --json file/out.json | cannot write 'file/out.json': File exists
evaluate --controller analytic --load x.npz | --load: controller 'analytic' learns nothing that could be k
evaluate --controller analytic --save x.npz | --save: controller 'analytic' learns nothing that could be k
evaluate --controller ridge --load none.npz | 'none.npz' does not exist
evaluate --controller ridge --load file | 'file' holds no saved controller
evaluate --controller ridge --save folder | cannot write 'folder': it is a folder
evaluate --controller ridge --save file/x.npz | cannot write 'file/x.npz': File exists
evaluate --controller ridge --load x.npz --env ToyThrow-v0 | 'x.npz' holds no saved controller
evaluate --controller os:path | module 'os' has no class 'path'
evaluate --controller os:nothing | module 'os' has no class 'nothing'
evaluate --controller nobody:Mine | module 'nobody' cannot be imported: ModuleNotFoundError: No
evaluate --controller : | module '' cannot be imported: ValueError: Empty module name
evaluate --controller Analytic | 'Analytic' is neither a controller
evaluate --controller "analytic " | 'analytic' is neither a controller
evaluate --controller analytic,ridge | 'analytic,ridge' is neither a controller
evaluate --controller file | 'file' is neither a controller
evaluate --controller folder | 'folder' is not a run folder: it has no args.yml
evaluate --controller file.zip | 'file.zip' is not a run folder of agents.train: loading it r
evaluate --controller file.zip --trust | 'file.zip' is damaged: file.zip is truncated or not a model
evaluate --controller none.zip --trust | model 'none.zip' does not exist
evaluate --controller ballistic | 'ballistic' is neither a controller
evaluate --controller analytic_height --env OneJointThrow-v0 | controller 'analytic_height' knows the physics of the c
evaluate --controller mlp --action-mode release_xyz | controller 'mlp' shifts the landing and needs an action of 2
evaluate --controller policy --env OneJointThrow-v0 | level file 'policy/env.yaml': unknown key 'action.along'
evaluate --controller policy --action-mode release_xyz | the policy of 'policy' takes observations (26,) and gives ac
evaluate --controller torn | 'torn/policy.npz' is damaged: policy.npz is truncated or holds no policy
evaluate --controller foreign | 'foreign/policy.npz' is damaged: policy.npz is truncated or holds no policy
evaluate --controller written | 'written/policy.npz' is damaged: policy.npz is truncated or holds no policy
evaluate --controller old | run folder 'old' is damaged: policy.npz is missing; before 0.2.0 none was written
evaluate --controller policy/policy.npz | 'policy/policy.npz' is neither a controller
evaluate --controller policy --level nominal.yaml | level file 'nominal.yaml': mismatch is 9: input should be le
evaluate --controller analytic --env CartPole-v1 | environment 'CartPole-v1' has no core, so it is none of a ce
train extra | Unrecognized options: extra
train --steps 0 | --steps is 0; it must be at least 1
train --steps -1 | --steps is -1; it must be at least 1
train --steps x | Error parsing --steps: no type matching {None}|INT could be
train --seed -1 | --seed is -1; it must be at least 0
train --env OneJointThrow-v0 --fidelity flight | --fidelity flight: environment 'OneJointThrow-v0' is simulated i
train --fidelity half | invalid choice 'half' for argument '--fidelity'
train --full-last 10 | --full-last goes with --fidelity flight
train --full-last -1 --fidelity flight | --full-last is -1; it must be at least 0
train --num-envs 0 | --num-envs is 0; it must be at least 1
train --num-envs 100001 | num_envs is 100001; it must be a whole number from 1 to 1000
train --threads 0 | --threads is 0; it must be at least 1
train --eval-picks -1 | --eval-picks is -1; it must be at least 0
train --checkpoint-every 0 | --checkpoint-every is 0; it must be at least 1
train --algo dqn | invalid choice 'dqn' for argument '--algo'
train --algo SAC | invalid choice 'SAC' for argument '--algo'
train --algo "" | invalid choice '' for argument '--algo'
train --algo recurrent_ppo | algorithm 'recurrent_ppo' goes by where a shift begins, which observations here do not tell
train --algo recurrent_ppo --env OneJointSort-v0 | algorithm 'recurrent_ppo' goes by where a shift begins, which
train --algo rppo --env PnTAdapt-v0 | invalid choice 'rppo' for argument '--algo'
train --stack 0 --env PnTAdapt-v0 | --stack is 0; it must be at least 1
train --stack x --env PnTAdapt-v0 | Error parsing --stack: no type matching {None}|INT could be
train --stack 101 --env PnTAdapt-v0 | stack is 101; a policy sees from 1 to 100 observations at once
train --stack 8 | a stack of 8 observations goes by where a shift begins, which observations here do not tell; use PnTA
train --stack 2 --env GripperToss-v0 | a stack of 2 observations goes by where a shift begins, which
train --over mlp --env PnTAdapt-v0 | over is 'mlp'; it must be a controller that needs no practice: analytic, analyt
train --over oracle | over is 'oracle'; it must be a controller that needs no practice
train --over policy | over is 'policy'; it must be a controller that needs no practice
train --over os:path | over is 'os:path'; it must be a controller that needs no practice
train --over static | controller 'static' goes by what is told of the throw before; use --env PnTAdapt-v0
train --over mean_lead --env OneJointThrow-v0 | controller 'mean_lead' knows the physics of the c
train --env Nowhere-v0 | unknown environment 'Nowhere-v0'; known are PnTConveyor-v0,
train --env CartPole-v1 | environment 'CartPole-v1' has no core, so it is none of a ce
train --level nowhere | unknown level 'nowhere'; shipped levels are day, day_far, dense, drift_mix
train --level day | level 'day' drifts, and nothing in this environment tells
train --level heavy.yaml | level file 'heavy.yaml': suction.tau is 1000000000.0: input
train --action-mode nowhere | action_mode is 'nowhere'; it must be one of release_point, r
train --config none.yml | cannot read hyperparameters 'none.yml': No such file or dire
train --config folder | cannot read hyperparameters 'folder': Is a directory
train --config text.yaml | hyperparameters 'text.yaml' have no entry for 'PnTConveyor-v
train --config file | hyperparameters 'file' have no entry for 'PnTConveyor-v0'; e
train --out file | 'file' exists already; choose another --out, or continue it
train --out folder/full | 'folder/full' exists already; choose another --out, or conti
train --out file/run | cannot write run folder 'file/run': Not a directory
train --resume none | run folder 'none' does not exist
train --resume folder | 'folder' is not a run folder: it has no args.yml
train --resume file | run folder 'file' does not exist
train --resume "" | '.' is not a run folder: it has no args.yml
train --resume policy | run folder 'policy' is damaged: it has no checkpoint
train --resume policy --steps 20000 | run folder 'policy' is damaged: it has no checkpoint
train --resume policy --algo ppo | --algo cannot be changed with --resume: the run folder has s
train --resume policy --stack 4 | --stack cannot be changed with --resume: the run folder has s
train --resume policy --over static | --over cannot be changed with --resume: the run folder has s
train --resume policy --seed 1 | --seed cannot be changed with --resume: the run folder has s
train --resume policy --num-envs 4 | --num-envs cannot be changed with --resume: the run folder h
train --resume policy --out x | --out cannot be changed with --resume: the run folder has se
train --resume policy --env PnTConveyor-v0 | --env cannot be changed with --resume: the run folder has se
train --resume none --steps 0 | --steps is 0; it must be at least 1
benchmark extra | Unrecognized options: extra
benchmark --config none.yaml | cannot read benchmark 'none.yaml': No such file or directory
benchmark --config folder | cannot read benchmark 'folder': Is a directory
benchmark --config text.yaml | benchmark 'text.yaml': is 'text': input should be a valid di
benchmark --config typo.yaml | benchmark 'typo.yaml': key 'name' is missing
benchmark --config plan.yaml --jobs 0 | --jobs is 0; it must be at least 1
benchmark --config plan.yaml --jobs x | Error parsing --jobs: invalid literal for int() with base 10
benchmark --config plan.yaml --out folder | cannot write 'folder': it is a folder
benchmark --config plan.yaml --out file/out.json | cannot write 'file/out.json': File exists
benchmark --config plan.yaml --out o.json --work file | cannot write 'file/piece.json': File exists
benchmark --config plan.yaml --out o.json --work file/inner | cannot write 'file/inner/piece.json': Not a directory
benchmark --config nobody.yaml | benchmark 'nobody.yaml': unknown controller 'nobody'; known
benchmark --config stacked.yaml | benchmark 'stacked.yaml': entry 'a': stack, over and fidelity are for sac, td3, ppo, t
benchmark --config over.yaml | benchmark 'over.yaml': entry 'a' has stack 8 over 'mlp'; it must be 1 to 100 over one of
benchmark --config nowhere.yaml | unknown level 'nowhere'; shipped levels are day, day_far, dense, drift_mix
reproduce | Missing from python -m agents.reproduce: hassan|choe|miyashi
reproduce nobody | unknown paper 'nobody'; known are hassan, choe, miyashita, l
reproduce hassan choe | Unrecognized options: choe
reproduce hassan --only nothing | unknown part 'nothing'; known are table1, free-direction, fr
reproduce hassan --jobs 0 | --jobs is 0; it must be at least 1
reproduce hassan --jobs x | Error parsing --jobs: no type matching {None}|INT could be i
reproduce hassan --json folder | cannot write 'folder': it is a folder
reproduce hassan --json file/out.json | cannot write 'file/out.json': File exists
reproduce hassan --figures file | cannot write 'file/drawing.svg': File exists
reproduce hassan --figures file/drawings | cannot write 'file/drawings/drawing.svg': Not a directory
reproduce hassan --work file | cannot write 'file/piece.json': File exists
reproduce Hassan | unknown paper 'Hassan'; known are hassan, choe, miyashita, l
report extra | Unrecognized options: extra
report --results none | 'none' holds no results yet; `python -m agents.benchmark` ma
report --results file | 'file' holds no results yet; `python -m agents.benchmark` ma
report --results folder | 'folder' holds no results yet; `python -m agents.benchmark`
report --results broken | cannot read 'broken/x.json': it is not valid JSON: Expecting
report --redme x | Unrecognized options: --redme, x; perhaps you meant --readme
play | give one of --video FILE.mp4, --picture FILE.png and --viewe
play --picture folder | cannot write 'folder': it is a folder
play --picture x.png --video x.mp4 | give one of --video FILE.mp4, --picture FILE.png and --viewe
play --picture file/x.png | cannot write 'file/x.png': File exists
play --picture x.png --at -1 | --at is -1.0 s; it must be finite and not negative
play --picture x.png --at nan | --at is nan s; it must be finite and not negative
play --picture x.png --picks 0 | --picks is 0; it must be at least 1
play --picture x.png --seed -1 | --seed is -1; it must be at least 0
play --video x.mp4 --slow 0 | --slow is 0; it must be at least 1
play --viewer hologram | invalid choice 'hologram' for argument '--viewer'
play --viewer native --picture x.png | give one of --video FILE.mp4, --picture FILE.png and --viewe
play --picture x.png --controller nobody | 'nobody' is neither a controller
play --picture x.png --env Nowhere-v0 | unknown environment 'Nowhere-v0'; known are PnTConveyor-v0,
play --picture x.png --level nowhere | unknown level 'nowhere'; shipped levels are day, day_far, dense, drift_mix
play --picture x.png --level day | level 'day' drifts, and nothing in this environment tells
play --picture x.png --controller torn | 'torn/policy.npz' is damaged: policy.npz is truncated or holds no policy
play --picture x.png --controller old | run folder 'old' is damaged: policy.npz is missing; before 0.2.0
publish | Missing from python -m agents.publish: PATH The run folder
publish none | run folder 'none' does not exist
publish folder | 'folder' is not a run folder: it has no args.yml
publish file | run folder 'file' does not exist
publish policy --picks 0 | --picks is 0; it must be at least 1
publish policy --shifts 3 | --shifts goes with work shifts; PnTRelease-v0 is judged by throws
publish policy --seed -1 | --seed is -1; it must be at least 0
publish policy --no-onx | Unrecognized options: --no-onx; perhaps you meant --onnx
publish policy --video x.mp4 | Unrecognized options: x.mp4
publish policy/policy.npz | run folder 'policy/policy.npz' does not exist
publish torn --to kept | 'torn/policy.npz' is damaged: policy.npz is truncated or holds no policy
publish foreign --to kept | 'foreign/policy.npz' is damaged: policy.npz is truncated or holds no policy
publish old --to kept | run folder 'old' is damaged: policy.npz is missing; before 0.2.0 none was written
publish policy --to file | cannot read or write 'file/
publish policy --to kept --levels nowhere | unknown level 'nowhere'; shipped levels are day, day_far, dense, drift_mix
publish policy --env nobody:Cell-v0 | module 'nobody' cannot be imported: ModuleNotFoundError: No
publish policy policy | Unrecognized options: policy
dataset extra | Unrecognized options: extra
dataset --throws 0 | --throws is 0; it must be at least 1
dataset --throws x | Error parsing --throws: invalid literal for int() with base
dataset --score-throws 0 | --score-throws is 0; it must be at least 1
dataset --seed -1 | --seed is -1; it must be at least 0
dataset --practice -1 | --practice is -1; it must be at least 0
dataset --num-envs 0 | --num-envs is 0; it must be at least 1
dataset --num-envs 100001 | num_envs is 100001; it must be a whole number from 1 to 1000
dataset --jobs 0 | --jobs is 0; it must be at least 1
dataset --name "" | --name is ''; it must be NAMESPACE/NAME-vN
dataset --name waste | --name is 'waste'; it must be NAMESPACE/NAME-vN
dataset --name pnt_gym/release/waste | --name is 'pnt_gym/release/waste'; it must be NAMESPACE/NAME-vN
dataset --name ../waste-v0 | --name is '../waste-v0'; it must be NAMESPACE/NAME-vN
dataset --name /elsewhere/waste-v0 | --name is '/elsewhere/waste-v0'; it must be NAMESPACE/NAME-vN
dataset --name "one two-v0" | --name is 'one two-v0'; it must be NAMESPACE/NAME-vN
dataset --name one/two-v0 --root datasets | 'one/two-v0' exists already in
dataset --name one/two-v0/three-v0 --root datasets | 'one/two-v0/three-v0' would lie in
dataset --root file | cannot read or write
dataset --root file/inner | cannot read or write
dataset --controller nobody | 'nobody' is neither a controller
dataset --controller file.zip | 'file.zip' is not a run folder of agents.train: loading it r
dataset --controller folder | 'folder' is not a run folder: it has no args.yml
dataset --controller policy --action-mode release_xyz | the policy of
dataset --expert nobody | 'nobody' is neither a controller
dataset --expert virtual_goal --action-mode release_xyz | controller 'virtual_goal' shifts the landing and needs an act
dataset --env Nowhere-v0 | unknown environment 'Nowhere-v0'; known are PnTConveyor-v0,
dataset --env CartPole-v1 | environment 'CartPole-v1' has no core, so it is none of a ce
dataset --env ToyThrow-v0 | environment 'ToyThrow-v0' cannot be collected: its core has no cell
dataset --env OneJointThrow-v0 --level waste | unknown level 'waste'; shipped levels are contac
dataset --level nowhere | unknown level 'nowhere'; shipped levels are day, day_far, dense, drift_mix
dataset --level day | level 'day' drifts, and nothing in this environment tells
dataset --level heavy.yaml | level file 'heavy.yaml': suction.tau is 1000000000.0: input
dataset --action-mode nowhere | action_mode is 'nowhere'; it must be one of release_point, r
levels extra | Unrecognized options: extra
levels --env Nowhere-v0 | Unrecognized options: --env, Nowhere-v0
doctor extra | Unrecognized options: extra
demo --picks 0 | --picks is 0; it must be at least 1
demo --threads 0 | --threads is 0; it must be at least 1
demo --seed -1 | --seed is -1; it must be at least 0
"""
