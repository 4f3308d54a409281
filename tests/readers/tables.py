#!/usr/bin/env python3
"""Tables as pandas reads them: tables.py LAMELLA. Ends with 77 where pandas is missing."""

import json
import math

from support import box_stl, main, need

pandas = need("pandas")

NAMES = ["a", 'b, "left"', "größe"]


def test(run):
    folder = run.folder
    for i, mesh in enumerate(NAMES):
        (folder / f"{mesh}.stl").write_bytes(box_stl((i, 0, 0), (i + 2, 3 + i, 10)))
    meshes = [f"{mesh}.stl" for mesh in NAMES]
    run("slice", *meshes, "--planes=-1,1,2.5,9,11", "-o", "t.csv", "-o", "t.jsonl")
    table = pandas.read_csv(folder / "t.csv", float_precision="round_trip")
    assert list(table["mesh"].unique()) == NAMES, table["mesh"].unique()
    assert len(table) == 15 and list(table["height_mm"][:5]) == [-1, 1, 2.5, 9, 11]
    for i, mesh in enumerate(NAMES):
        rows = table[table["mesh"] == mesh].reset_index()
        inside = rows["height_mm"].between(0, 10)
        assert (rows["area_mm2"][inside] == 2 * (3 + i)).all() and (rows["area_mm2"][~inside] == 0).all()
        assert (rows["perimeter_mm"][inside] == 2 * (2 + 3 + i)).all()
        assert (rows["contours"][inside] == 1).all() and (rows[["holes", "open", "flat"]] == 0).all().all()
        assert (rows["centroid_x_mm"][inside] == i + 1).all() and (rows["centroid_y_mm"][inside] == (3 + i) / 2).all()
        assert (rows["min_x_mm"][inside] == i).all() and (rows["max_y_mm"][inside] == 3 + i).all()
        # An empty layer has no centroid and no box.
        assert rows.loc[~inside, ["centroid_x_mm", "centroid_y_mm", "min_x_mm", "max_y_mm"]].isna().all().all()
    facts = pandas.read_csv(folder / "t.meshes.csv").set_index("mesh")
    assert list(facts.index) == NAMES and (facts["triangles"] == 12).all()
    assert math.isclose(facts.loc[NAMES[2], "volume_mm3"], 2 * 5 * 10, rel_tol=1e-5)
    assert math.isclose(facts.loc[NAMES[2], "surface_mm2"], 2 * (2 * 5 + 2 * 10 + 5 * 10), rel_tol=1e-5)
    lines = pandas.read_json(folder / "t.jsonl", lines=True, precise_float=True)
    layers = lines[lines["kind"] == "layer"].drop(columns="kind").dropna(axis=1, how="all").reset_index(drop=True)
    assert len(lines) == 18 and len(layers) == 15
    for column in table.columns:
        same = layers[column].astype(table[column].dtype)
        assert same.equals(table[column]), column
    for line in (folder / "t.jsonl").read_text(encoding="utf-8").splitlines():
        assert json.loads(line)["mesh"] in NAMES


main(test)
