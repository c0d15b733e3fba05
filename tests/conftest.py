"""Settings for all tests: no OpenGL window, and no thread pools beside the ones a test asks for."""

import os

os.environ.setdefault("MUJOCO_GL", "egl")
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
