"""What `omnimorph bench --peers` runs: others on the same problems and on equal work.

Every peer is optional (extra ``bench``); one that is not installed is named in the report.
"""

from __future__ import annotations

from benchmarks.peers.suite import measure_peers

__all__ = ["measure_peers"]
