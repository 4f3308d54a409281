// node test.mjs TOOL NODE_MODULES, in a folder with lamella, example.mjs and bone.stl: tests in node, and in Chromium by playwright-core of NODE_MODULES.
const [{ deepStrictEqual: equal }, { execFileSync }, { readFileSync: read }, { createServer }, { createRequire, syncBuiltinESMExports }, threads, { gzipSync }] =
    await Promise.all(["assert", "child_process", "fs", "http", "module", "worker_threads", "zlib"].map((name) => import(`node:${name}`)));

/// In node or in a page: what calls give, as text. Workers of pools are counted, and the first is ended.
async function cases(all) {
    const inPage = "document" in globalThis, started = [], lines = [], { SlicePool, Slicer } = await import("lamella");
    const Watched = class extends (inPage ? Worker : threads.Worker) { constructor(...words) { super(...words); started.push(this); } };
    inPage ? (globalThis.Worker = Watched) : (createRequire("/")("worker_threads").Worker = Watched, syncBuiltinESMExports());
    const slicer = await Slicer.load(), view = new DataView(inPage ? await (await fetch("/bone.stl")).arrayBuffer() : Uint8Array.from(read("bone.stl")).buffer);
    const positions = Float32Array.from({ length: 9 * view.getUint32(80, true) }, (_, i) => view.getFloat32(96 + 50 * Math.floor(i / 9) + 4 * (i % 9), true)), mesh = { positions };
    const keys = Array.from({ length: positions.length / 3 }, (_, i) => positions.subarray(3 * i, 3 * i + 3).join()), corners = new Map([...new Set(keys)].map((key, i) => [key, i]));
    const indexed = { positions: Float32Array.from([...corners.keys()].join().split(",")), indices: Uint32Array.from(keys, (key) => corners.get(key)) };
    const doubles = { positions: Float64Array.from(positions, (x) => x / 4), mmPerUnit: 4 }, aside = { positions: new Float32Array([7, ...positions, 7]).subarray(1, -1), indices: null };
    const heights = new Set([30, 1.5, 20]), results = [[mesh, { ...all, firstLayer: 5, endLayer: 40 }], [mesh, { heights }], [doubles, { heights }], [indexed], [aside], [mesh]]
        .map((given) => slicer.slice(...given)), whole = results.at(-1);
    const nested = { positions: Float32Array.from([...positions.map((x, i) => (i % 3 < 2 ? 2 * x : x)), ...positions]) }, tube = { positions: positions.subarray(8100) };
    const [ring] = slicer.slice(nested, { heights: [20], fillRule: "even-odd" }).layers, open = slicer.slice(tube, { stitch: 0 }).layers.find(({ area }) => isNaN(area));
    lines.push(...results.map(({ hash }) => hash), `${whole.info.layers} ${whole.info.contours} ${whole.info.segments}`, open.contours.some(({ role }) => role === "open"),
        ring.contours.map(({ role, parent }) => `${role} ${parent}`).join(), (-4 * ring.contours[1].area / ring.contours[0].area).toFixed(3));
    const refused = async (call) => lines.push(await call().then(() => "no error", ({ code, message }) => (/^[^\n]{15,120}$/.test(message) ? code : message)));
    for (const given of [[mesh, { layerHeight: 0 }], [mesh, { layerHeight: NaN }], [mesh, { layerHeigth: 1 }], [mesh, { fillRule: "x" }], [mesh, { firstLayer: -1 }], [mesh, { heights: 3 }],
        [mesh, { heights: [NaN] }], [mesh, { layerHeight: 2e-5 }], [{}], [{ positions: new Float32Array(8) }], [{ positions: new Float32Array(0) }], [{ positions, indices: new Uint16Array(4) }],
        [{ positions: positions.map((x, i) => (i === 99 ? NaN : x)) }], [{ positions, indices: new Uint32Array([1e6, 1, 2]) }], [{ positions, mmPerUnit: 0 }]]) {
        await refused(async () => slicer.slice(...given));
    }
    const pool = await SlicePool.create({ workers: 2 });
    lines.push((await pool.slice([nested, mesh, tube, indexed])).map(({ info }) => info.triangles).join());
    const ranges = await Promise.all([{ endLayer: 300 }, { firstLayer: 300 }].map((range) => pool.sliceOne(mesh, range)));
    lines.push(JSON.stringify(ranges.flatMap(({ layers }) => layers)) === JSON.stringify(whole.layers));
    await refused(() => pool.sliceOne(mesh, { layerHeight: 0 }));
    const one = pool.sliceOne(mesh), two = pool.slice([mesh, mesh]);
    inPage ? started[0].dispatchEvent(new ErrorEvent("error", { message: "out of memory" })) : started[0].terminate();
    await refused(() => one);
    lines.push((await two)[1].hash, started.length);
    await Promise.all([refused(() => pool.slice([mesh, mesh, mesh])), pool.close()]);
    await refused(() => pool.sliceOne(mesh));
    return lines;
}

const [, , tool, modules] = process.argv, run = (...words) => execFileSync(...words, { encoding: "utf8" }), printed = /```text\n([^]*?)```/.exec(read("node_modules/lamella/README.md"))[1];
const all = { layerHeight: 0.3, firstHeight: 0.1, stitch: 0, fillRule: "even-odd", closing: 0.05, offset: 0.1, simplify: 0.01, grid: 0.0001 };
const flags = Object.entries(all).flatMap(([name, value]) => [`--${name.replace(/[A-Z]/, (letter) => `-${letter.toLowerCase()}`)}`, `${value}`]), invalid = "invalid_argument";
const hash = (words) => /^hash +(\w+)/m.exec(run(tool, ["slice", "bone.stl", "--hash", ...words]))[1], whole = hash([]), planes = hash(["--planes", "30,1.5,20"]);
const expected = [hash([...flags, "--layers", "5:40"]), planes, planes, whole, whole, whole, "741 764 101502", true, "outer -1,hole 0", "1.000", ...Array(6).fill(invalid), "bad_planes",
    "result_too_large", "malformed_mesh", "malformed_mesh", "empty_mesh", "malformed_mesh", "bad_coordinate", invalid, invalid, "40000,20000,19100,20000", true, invalid, "lost", whole, 3,
    "cancelled", "cancelled"];
equal(await cases(all), expected);
equal(run(process.execPath, ["example.mjs"]), printed);

const { chromium } = await import(`${modules}/playwright-core/index.mjs`), loaded = new Map(), said = [];
const home = `<link rel="icon" href="data:,"><script type="importmap">{ "imports": { "lamella": "/node_modules/lamella/index.js" } }</script>`;
const server = createServer(({ url }, response) => {
    loaded.set(url, url === "/" ? home : read(`.${url}`));
    response.writeHead(200, { "content-type": url === "/" ? "text/html" : /js$/.test(url) ? "text/javascript" : "application/octet-stream" }).end(loaded.get(url));
});
await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--disable-dev-shm-usage"] }), page = await browser.newPage();
page.on("console", (message) => said.push(`${message.text()}\n`)).on("pageerror", (error) => said.push(`${error}`));
await page.goto(`http://127.0.0.1:${server.address().port}/`);
await page.evaluate(() => import("/example.mjs"));
equal(said.join(""), printed);
equal(await page.evaluate(cases, all), expected);
const bytes = [...loaded].reduce((sum, [url, body]) => sum + (/lamella/.test(url) ? gzipSync(body, { level: 9 }).length : 0), 0);
equal([loaded.size, bytes < 300_000], [7, true]);
console.log(`node ${process.version}, Chromium ${browser.version()}: ${expected.length} answers as expected; a page loads ${bytes} bytes gzipped`);
await Promise.all([browser.close(), server.close()]);
