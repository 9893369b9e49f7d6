#!/usr/bin/env bash
# Workers of a farm as a job array of Slurm (docs/farm.md): each task is a worker, until Slurm ends
# it or the farm drains it. `sbatch --array=1-16 docker/farm/slurm_array.sh`, with QRAYD_STORE and
# QRAYD_DATA (the shared folder) in the environment; the password in ~/.pgpass or PGPASSWORD.
#SBATCH --job-name=qray-worker
#SBATCH --cpus-per-task=8
#SBATCH --mem=16G
#SBATCH --time=12:00:00
# A minute before the time is over, or when the task makes room for others: the worker writes its
# job's state and gives it back, which takes 2 s.
#SBATCH --signal=TERM@60
#SBATCH --requeue
#SBATCH --output=qray-worker-%A_%a.log
set -euo pipefail

: "${QRAYD_STORE:?expected postgresql://... in QRAYD_STORE}"
: "${QRAYD_DATA:?expected the shared folder in QRAYD_DATA}"
# `exec` and srun, so that the signal reaches the worker itself.
exec srun qrayd worker --threads "${SLURM_CPUS_PER_TASK:-1}" \
  --jobs-mib "$((${SLURM_MEM_PER_NODE:-16384} * 3 / 4))"
