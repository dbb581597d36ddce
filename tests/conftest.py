"""One thread of linear algebra a process: tests run beside each other, and threads that wait for each other burn CPU.

On two busy cores products of small matrices on two threads cost six times the CPU of one. The libraries read these
settings when numpy is first imported, which is after this file.
"""

import os

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
