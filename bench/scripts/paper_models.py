"""The paper's 13 models, what its Tables 1 to 4 say about them, and the stand-ins for models that are not available."""
from typing import NamedTuple, Optional

LAYER_MM = 0.032
RANDOM_MM = "0.016:0.032"
ALIKE = {"n": 0.01, "m": 0.05, "k": 0}  # largest relative differences of a stand-in from the paper's model, with uniform planes


class Model(NamedTuple):
    name: str
    n: int
    k: int  # for uniform planes
    m: int
    k_random: int
    m_random: int
    slicing: tuple  # Table 2, seconds: Park, Slic3r, proposed; then adaptive: Park, proposed
    contours: tuple  # Table 3: trivial, Park, Slic3r, proposed
    # Shape, height in mm at which as many planes cut the mesh, and seed of `lamella make`; None: there is no stand-in
    recipe: Optional[tuple] = None

    def totals(self):
        """The totals of Table 4: Park, Slic3r, proposed."""
        park, slic3r, proposed = self.slicing[:3]
        _, park_contours, slic3r_contours, hashed = self.contours
        return (None if park_contours is None else park + park_contours, slic3r + slic3r_contours, proposed + hashed)


MODELS = [
    Model("liver", 38142, 6242, 2341955, 8327, 3125518, (1.28, 0.32, 0.10, 1.76, 0.17), (0.80, 35.97, 3.57, 1.03)),
    Model("femur", 42150, 3155, 1180994, 4206, 1575271, (0.53, 0.16, 0.05, 0.79, 0.09), (0.38, 16.59, 2.00, 0.50)),
    Model("bunny", 270021, 1547, 1561262, 2060, 2077024, (2.70, 0.29, 0.13, 3.52, 0.22), (1.23, 22.00, 8.51, 0.65),
          ("bone", 49.891, 3)),
    Model("demon", 935236, 3126, 6846219, 4168, 9134486, (20.12, 1.28, 0.53, 23.65, 1.23), (11.77, 140.77, 69.49, 2.93),
          ("gyroid", 100.192, 4)),
    Model("sphenoid", 983134, 1971, 3839399, 2623, 5129972, (7.73, 0.61, 0.29, 10.15, 0.59), (7.81, 73.26, 38.24, 1.64),
          ("bone", 63.686, 5)),
    Model("rider", 1281950, 849, 1569364, 1127, 2085785, (6.37, 0.54, 0.33, 8.51, 0.64), (2.03, 27.82, 25.02, 0.61),
          ("bone", 27.297, 6)),
    Model("tesla", 2296928, 4547, 11309068, 6062, 15172446, (39.12, 1.60, 0.56, 53.09, 2.73),
          (23.16, 238.59, 213.04, 4.76), ("gyroid", 145.6, 7)),
    Model("sphere", 3060992, 6038, 19083782, 8055, 25484004, (91.70, 2.75, 0.97, 121.50, 4.82),
          (63.79, 407.57, 405.08, 8.63), ("sphere", 193.216, 8)),
    Model("soldier", 3394041, 2390, 11663621, 3183, 15555765, (45.45, 2.24, 1.28, 60.13, 2.61),
          (46.69, 275.14, 176.06, 5.09), ("bone", 77.093, 9)),
    Model("bear", 6248232, 3961, 43346582, 5280, 57836973, (95.71, 6.07, 2.49, 126.87, 7.96),
          (417.50, 1507.52, 530.49, 19.66), ("bone", 127.428, 10)),
    Model("warrior", 8852207, 307, 912739, 405, 1220672, (13.21, 0.54, 0.64, 17.52, 1.47), (0.38, 6.69, 48.30, 0.14),
          ("bone", 9.954, 11)),
    Model("robot", 12274288, 1011, 6879612, 1344, 9144887, (60.11, 1.59, 1.25, 79.81, 3.47), (14.85, 75.05, 251.59, 1.50),
          ("bone", 32.513, 12)),
    Model("skull", 16668257, 4680, 182441957, 6240, 243094438, (389.80, 24.54, 17.42, 519.03, 40.29),
          (8094.36, None, 2165.11, 101.04), ("gyroid", 150.951, 13)),
]
QUICK = ("liver", "femur", "bunny")
