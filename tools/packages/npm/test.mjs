// node test.mjs TOOL NODE_MODULES, in a folder with lamella, example.mjs and bone.stl: the same calls in node, and in Chromium by
// playwright-core of NODE_MODULES, against the tool.
import { deepStrictEqual as equal } from "node:assert";
import { execFileSync } from "node:child_process";
import { readFileSync as read } from "node:fs";
import { createServer } from "node:http";
import { gzipSync } from "node:zlib";

const [, , tool, modules] = process.argv;
const run = (...words) => execFileSync(...words, { encoding: "utf8" });
const hash = (...words) => /^hash +(\w+)/m.exec(run(tool, ["slice", "bone.stl", "--hash", ...words]))[1];

/// In node or in a page: what calls give, as text. Nothing around it is seen, as its text is what a page gets.
async function answers(options) {
    const in_page = "document" in globalThis;
    const started = []; // workers of pools
    const watch = (kind) => class extends kind { constructor(...words) { super(...words); started.push(this); } };
    if (in_page) {
        globalThis.Worker = watch(Worker);
    } else {
        const { createRequire, syncBuiltinESMExports } = await import("node:module");
        const threads = createRequire("/")("worker_threads");
        threads.Worker = watch(threads.Worker);
        syncBuiltinESMExports();
    }
    const bytes = in_page ? await (await fetch("/bone.stl")).arrayBuffer() : Uint8Array.from((await import("node:fs")).readFileSync("bone.stl")).buffer;
    const stl = new DataView(bytes);
    const positions = Float32Array.from({ length: 9 * stl.getUint32(80, true) }, (_, i) => stl.getFloat32(96 + 50 * Math.floor(i / 9) + 4 * (i % 9), true));
    const mesh = { positions };

    const { SlicePool, Slicer } = await import("lamella");
    const slicer = await Slicer.load();
    const found = {};
    const hash_of = (...given) => slicer.slice(...given).hash;
    found.options = hash_of(mesh, { ...options, firstLayer: 5, endLayer: 40 });

    const heights = new Set([30, 1.5, 20]);
    const doubles = { positions: Float64Array.from(positions, (x) => x / 4), mmPerUnit: 4 };
    found.heights = [hash_of(mesh, { heights }), hash_of(doubles, { heights })];

    const keys = Array.from({ length: positions.length / 3 }, (_, i) => positions.subarray(3 * i, 3 * i + 3).join());
    const corners = new Map([...new Set(keys)].map((key, i) => [key, i]));
    const indexed = { positions: Float32Array.from([...corners.keys()].join().split(",")), indices: Uint32Array.from(keys, (key) => corners.get(key)) };
    const aside = { positions: new Float32Array([7, ...positions, 7]).subarray(1, -1), indices: null };
    const whole = slicer.slice(mesh);
    found.whole = [whole.hash, hash_of(indexed), hash_of(aside)];
    found.counts = [whole.info.layers, whole.info.contours, whole.info.segments];

    const twice = { positions: Float32Array.from([...positions.map((x, i) => (i % 3 < 2 ? 2 * x : x)), ...positions]) };
    const [ring] = slicer.slice(twice, { heights: [20], fillRule: "even-odd" }).layers;
    found.ring = ring.contours.map(({ role, parent }) => `${role} ${parent}`);
    found.share = ((-4 * ring.contours[1].area) / ring.contours[0].area).toFixed(3);
    const cut = { positions: positions.subarray(8100) };
    const open = slicer.slice(cut, { stitch: 0 }).layers.find(({ area }) => isNaN(area));
    found.open = open.contours.some(({ role }) => role === "open");

    // The code, of one line.
    const refusal = (call) => call().then(() => "no error", ({ code, message }) => (/^[^\n]{15,120}$/.test(message) ? code : message));
    const wrong_options = [
        { layerHeight: 0 }, { layerHeight: NaN }, { layerHeigth: 1 }, { fillRule: "x" }, { firstLayer: -1 }, { heights: 3 }, { heights: [NaN] }, { layerHeight: 2e-5 },
    ];
    const wrong_meshes = [
        {}, { positions: new Float32Array(8) }, { positions: new Float32Array(0) }, { positions, indices: new Uint16Array(4) },
        { positions: positions.map((x, i) => (i === 99 ? NaN : x)) }, { positions, indices: new Uint32Array([1e6, 1, 2]) }, { positions, mmPerUnit: 0 },
    ];
    found.refused = [];
    for (const given of [...wrong_options.map((one) => [mesh, one]), ...wrong_meshes.map((one) => [one])]) {
        found.refused.push(await refusal(async () => slicer.slice(...given)));
    }

    const pool = await SlicePool.create({ workers: 2 });
    found.order = (await pool.slice([twice, mesh, cut, indexed])).map(({ info }) => info.triangles);
    const ranges = await Promise.all([{ endLayer: 300 }, { firstLayer: 300 }].map((range) => pool.sliceOne(mesh, range)));
    found.ranges = JSON.stringify(ranges.flatMap(({ layers }) => layers)) === JSON.stringify(whole.layers);
    found.in_pool = await refusal(() => pool.sliceOne(mesh, { layerHeight: 0 }));
    const lost = pool.sliceOne(mesh), rest = pool.slice([mesh, mesh]);
    in_page ? started[0].dispatchEvent(new ErrorEvent("error", { message: "out of memory" })) : started[0].terminate();
    found.lost = [await refusal(() => lost), (await rest)[1].hash, started.length];
    found.closed = await Promise.all([refusal(() => pool.slice([mesh, mesh, mesh])), pool.close().then(() => refusal(() => pool.sliceOne(mesh)))]);
    return found;
}

const options = { layerHeight: 0.3, firstHeight: 0.1, stitch: 0, fillRule: "even-odd", closing: 0.05, offset: 0.1, simplify: 0.01, grid: 0.0001 };
const flags = Object.entries(options).flatMap(([name, value]) => [`--${name.replace(/[A-Z]/, (letter) => `-${letter.toLowerCase()}`)}`, `${value}`]);
const invalid = "invalid_argument", malformed = "malformed_mesh", whole = hash(), planes = hash("--planes", "30,1.5,20");
const expected = {
    options: hash(...flags, "--layers", "5:40"),
    heights: [planes, planes],
    whole: [whole, whole, whole],
    counts: [741, 764, 101502],
    ring: ["outer -1", "hole 0"],
    share: "1.000",
    open: true,
    refused: [
        invalid, invalid, invalid, invalid, invalid, invalid, "bad_planes", "result_too_large",
        malformed, malformed, "empty_mesh", malformed, "bad_coordinate", invalid, invalid,
    ],
    order: [40000, 20000, 19100, 20000],
    ranges: true,
    in_pool: invalid,
    lost: ["lost", whole, 3],
    closed: ["cancelled", "cancelled"],
};
const printed = /```text\n([^]*?)```/.exec(read("node_modules/lamella/README.md", "utf8"))[1];
equal(await answers(options), expected);
equal(run(process.execPath, ["example.mjs"]), printed);

const loaded = new Map();
const home = `<link rel="icon" href="data:,"><script type="importmap">{ "imports": { "lamella": "/node_modules/lamella/index.js" } }</script>`;
const server = createServer(({ url }, response) => {
    loaded.set(url, url === "/" ? home : read(`.${url}`));
    const type = url === "/" ? "text/html" : url.endsWith("js") ? "text/javascript" : "application/octet-stream";
    response.writeHead(200, { "content-type": type }).end(loaded.get(url));
});
await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
const { chromium } = await import(`${modules}/playwright-core/index.mjs`);
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--disable-dev-shm-usage"] });
const page = await browser.newPage();
const said = [];
page.on("console", (message) => said.push(`${message.text()}\n`));
page.on("pageerror", (error) => said.push(`${error}`));
await page.goto(`http://127.0.0.1:${server.address().port}/`);
await page.evaluate(() => import("/example.mjs"));
equal(said.join(""), printed);
equal(await page.evaluate(answers, options), expected);
const files = [...loaded].filter(([url]) => url.includes("lamella"));
const bytes = files.reduce((sum, [, body]) => sum + gzipSync(body, { level: 9 }).length, 0);
equal(files.length, 4); // index.js, slicer.js, worker.js, lamella.wasm
equal(bytes < 300_000, true);
console.log(`node ${process.version}, Chromium ${browser.version()}: as the tool; a page loads ${bytes} bytes gzipped`);
await browser.close();
server.close();
