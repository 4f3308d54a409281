/// A mesh to begin with: a ring whose tube swells five times, as binary STL.
export function example(): Blob {
    const around = 240, across = 60;
    const corner = (i: number, j: number): [number, number, number] => {
        const u = (2 * Math.PI * (i % around)) / around, v = (2 * Math.PI * (j % across)) / across;
        const tube = 5 + 1.6 * Math.cos(5 * u + 2 * v), reach = 18 + tube * Math.cos(v);
        return [reach * Math.cos(u), reach * Math.sin(u), 7 + tube * Math.sin(v)];
    };
    const bytes = new DataView(new ArrayBuffer(84 + 50 * 2 * around * across));
    bytes.setUint32(80, 2 * around * across, true);
    let at = 84;
    for (let i = 0; i < around; ++i) {
        for (let j = 0; j < across; ++j) {
            for (const corners of [[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]]) {
                at += 12;
                for (const [di, dj] of corners) {
                    for (const mm of corner(i + di!, j + dj!)) {
                        bytes.setFloat32(at, mm, true);
                        at += 4;
                    }
                }
                at += 2;
            }
        }
    }
    return new Blob([bytes.buffer]);
}
