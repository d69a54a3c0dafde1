"""Contact solvers of the package asperity and of Tamaas: `solvers.py NAME` answers the jobs of benchmarks/contact/peers.py."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "contact"))
import peers


class Asperity:
    """`asperity.solve_contact`."""

    package = "asperity"

    def __init__(self, job):
        import asperity

        self.asperity, self.job = asperity, job

    def prepare(self, heights):
        job = self.job
        map = self.asperity.HeightMap.from_array(heights, dx_m=1 / job["points"])
        return lambda: self.asperity.solve_contact(
            map, modulus_pa=1.0, mean_pressure_pa=job["mean_pressure"], hardness_pa=job["hardness"], boundary=job["boundary"],
            tolerance=job["tolerance"])

    def pressure(self, found):
        return found.pressure_pa


if __name__ == "__main__":
    peers.SOLVERS["asperity"] = Asperity
    peers.main()
