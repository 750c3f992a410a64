"""Do the shards of a folder that `newtau sweep --submit hyperqueue` wrote, on a HyperQueue cluster of this machine.

usage: hyperqueue.py FOLDER SHARDS WORKERS
"""

import sys
from pathlib import Path

# This file has the package's name: without its folder on the path, the package is found.
sys.path.pop(0)

from hyperqueue import Job, LocalCluster  # noqa: E402
from hyperqueue.cluster import WorkerConfig  # noqa: E402


def main(folder: Path, shards: int, workers: int) -> None:
    with LocalCluster() as cluster:
        for _ in range(workers):
            cluster.start_worker(WorkerConfig(cores=1))
        client = cluster.client()
        job = Job(max_fails=None)
        for shard in range(1, shards + 1):
            log = str(folder / "logs" / f"{shard}.log")
            job.program(["./shard.sh", str(shard)], cwd=folder, stdout=log, stderr=log, crash_limit=10)
        client.wait_for_jobs([client.submit(job)])


main(Path(sys.argv[1]).resolve(), int(sys.argv[2]), int(sys.argv[3]))
