// node page.js PAGE TOOL FOLDER [PICTURE]: the page against the tool, in headless Chromium. Exit status 77: there is no browser.
import { execFileSync, execSync } from "node:child_process";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import type { Browser, Download, Page } from "playwright-core";
import { ask, at, boxes, check, checked, drop, equal, go, hash_in, hash_of, launch, make, open_page, page_path, tool, tool_path, until, wrong } from "./browser";

const bone = () => make("bone", 20_000, "bone.stl");

async function numbers_are_the_tools(browser: Browser): Promise<void> {
    const page = await open_page(browser);
    await drop(page, bone());
    equal(await hash_of(page), hash_in(tool("slice", "bone.stl", "--hash", "-o", "bone.csv")), "hash");
    const [head, ...lines] = readFileSync(at("bone.csv"), "utf8").trim().split("\n").map((line) => line.split(","));
    const column = (name: string) => lines.map((line) => Number(line[head!.indexOf(name)]));
    const sums = await ask<number[]>(page, "[...state.sums]");
    const each = (which: number) => sums.filter((_, i) => i % 4 === which);
    equal(each(0), column("area_mm2"), "areas");
    equal(each(1), column("contours"), "contours");
    equal(each(2), column("holes"), "holes");
    await go(page, 124);
    equal(await ask(page, "state.layer.rows.reduce((sum, value, i) => sum + (i % 6 === 5 ? value : 0), 0)"), column("area_mm2")[124], "area of layer 124");
    await page.waitForFunction((area) => document.getElementById("area")!.textContent === area, `${Number(column("area_mm2")[124]!.toPrecision(6))} mm\u00b2`);
    equal(await save(page, "svg-all"), readFileSync(tool_svg()).toString("latin1"), "SVG");
    check((await save(page, "png")).startsWith("\x89PNG\r\n"), "no PNG");
    equal((await save(page, "csv-layers")).trim().split("\n").length, lines.length + 1, "lines of CSV");
    await settings_are_the_tools(page);
    await page.context().close();
}

function tool_svg(): string {
    tool("slice", "bone.stl", "-o", "bone.svg");
    return at("bone.svg");
}

async function save(page: Page, button: string): Promise<string> {
    const download = page.waitForEvent("download");
    await page.evaluate((id) => document.getElementById(id)!.click(), button);
    return readFileSync(await ((await download) as Download).path()).toString("latin1");
}

/// The command that the page shows prints the hash that it shows.
async function settings_are_the_tools(page: Page): Promise<void> {
    const tried: [Record<string, string>, string][] = [
        [{ height: "0.5" }, "height === 0.5"], [{ rule: "0", stitch: "0" }, "rule === 0 && state.plan.stitch === 0"],
        [{ rule: "1", closing: "0.3" }, "rule === 1 && state.plan.closing === 0.3"], [{ adaptive: "on" }, "cusp === 0.04"],
    ];
    for (const [settings, planned] of tried) {
        for (const [id, value] of Object.entries(settings)) {
            await (value === "on" ? page.check(`#${id}`) : id === "rule" ? page.selectOption("#rule", value) : page.fill(`#${id}`, value));
        }
        await until(page, `state.plan.${planned}`, "the plan");
        const hash = await hash_of(page);
        await page.click("[data-tab=mesh]");
        await page.waitForFunction((shown) => document.getElementById("panel")!.textContent!.includes(shown), hash);
        const command = await page.locator("#panel tr", { hasText: "at a terminal" }).locator("td").nth(1).textContent();
        const printed = execSync(command!.replace(/^lamella/, `'${tool_path}'`), { cwd: at(""), encoding: "utf8" });
        equal(hash, hash_in(printed), `hash of ${command}`);
    }
}

async function moves_are_followed(browser: Browser): Promise<void> {
    const page = await open_page(browser);
    await drop(page, bone());
    await hash_of(page);
    await page.click("#layer");
    await go(page, 100);
    for (const [key, layer] of [["ArrowUp", 101], ["w", 102], ["ArrowDown", 101], ["PageUp", 111], ["End", 740], ["Home", 0]] as const) {
        await page.keyboard.press(key);
        equal(await ask(page, "state.index"), layer, `layer after ${key}`);
    }
    await page.keyboard.press("g");
    await page.fill("#z", "12,4");
    await page.keyboard.press("Enter");
    const [low, high] = await ask<[number, number]>(page, "[state.slabs[2 * state.index], state.slabs[2 * state.index + 1]]");
    check(low <= 12.4 && 12.4 < high, "a typed height", [low, high]);
    const curve = (await page.locator("#curve").boundingBox())!;
    await page.mouse.click(curve.x + 40, curve.y + 12);
    check((await ask<number>(page, "state.index")) > 730, "a click near the curve's top");
    await page.hover("#curve");
    const before = await ask<number>(page, "state.index");
    await page.mouse.wheel(0, 100);
    await until(page, `state.index === ${before - 1}`, "a layer down by the wheel");

    const drawn = await page.evaluate(async () => {
        const { client, go, state } = (globalThis as never as { lamella: { client: { ask(q: object): void }; go(i: number): void; state: { layer: { index: number } } } }).lamella;
        client.ask({ ask: "slow", ms: 50 });
        const seen = new Set<number>(), begin = performance.now();
        for (let i = 0; i < 1000; ++i) {
            go((i * 37) % 700);
            seen.add(state.layer.index);
            while (performance.now() - begin < i) {
                await new Promise((resolve) => setTimeout(resolve, 0));
            }
        }
        return seen.size;
    });
    check(drawn <= 22, "planes cut in a second of moves", drawn);
    await page.waitForSelector(`body[data-layer="${(999 * 37) % 700}"]`);
    await page.context().close();
}

async function islands_and_overhang_are_found(browser: Browser): Promise<void> {
    const page = await open_page(browser);
    // A plate on a post, and a cube in the air.
    await drop(page, boxes("plate.stl", [[0, 0, 0, 10, 10, 5], [-5, -5, 5, 15, 15, 7], [30, 0, 3, 34, 4, 7]]));
    await hash_of(page);
    await until(page, "state.islands_upto === state.slabs.length / 2", "the islands");
    equal(await ask(page, "state.islands.map(({layer, x, y}) => [layer, Math.round(x), Math.round(y)])"), [[15, 32, 2]], "islands");
    await page.check("#overhang");
    await go(page, 25);
    await until(page, "state.below !== null && state.below.seq === state.layer.seq && state.below.ends.length > 0", "the overhang");
    const area = await ask<number>(page, "state.below.area");
    check(Math.abs(area - (400 - 10.4 ** 2)) < 1e-3, "overhang of the plate", area);
    await go(page, 26);
    await until(page, "state.below !== null && state.below.seq === state.layer.seq", "the layer above");
    equal(await ask(page, "state.below.area"), 0, "overhang above it");
    await parts_have_colours(page);
    await page.context().close();
}

/// A tetrahedron as PLY, and twice in a 3MF file.
async function other_files_open(browser: Browser): Promise<void> {
    const corners = [[0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 40]], faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    const lines = (all: number[][], before: string) => all.map((numbers) => `${before}${numbers.join(" ")}\n`).join("");
    writeFileSync(at("t.ply"), `ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n` +
        `element face 4\nproperty list uchar int vertex_indices\nend_header\n${lines(corners, "")}${lines(faces, "3 ")}`);
    const model = `<model xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" unit="millimeter"><resources><object id="1"><mesh><vertices>` +
        corners.map(([x, y, z]) => `<vertex x="${x}" y="${y}" z="${z}"/>`).join("") + "</vertices><triangles>" +
        faces.map(([a, b, c]) => `<triangle v1="${a}" v2="${b}" v3="${c}"/>`).join("") +
        `</triangles></mesh></object></resources><build><item objectid="1"/><item objectid="1" transform="1 0 0 0 1 0 0 0 1 50 0 0"/></build></model>`;
    const types = `<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ` +
        `ContentType="application/vnd.openxmlformats-package.relationships+xml"/></Types>`;
    const relation = `<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="r" Target="/3D/3dmodel.model" ` +
        `Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>`;
    execFileSync("python3", ["-c", "import sys, zipfile\nwith zipfile.ZipFile(sys.argv[1], 'w', zipfile.ZIP_DEFLATED) as z:\n" +
        " z.writestr('_rels/.rels', sys.argv[2]); z.writestr('3D/3dmodel.model', sys.argv[3]); z.writestr('[Content_Types].xml', sys.argv[4])", at("t.3mf"), relation, model, types]);
    const page = await open_page(browser);
    for (const [name, outers] of [["t.ply", 1], ["t.3mf", 2]] as const) {
        await drop(page, at(name));
        await until(page, `state.name === '${name}' && state.hash !== ''`, name);
        equal(await hash_of(page), hash_in(tool("slice", name, "--hash", "-o", "t.svg")), `hash of ${name}`);
        await until(page, `state.layer !== null && state.layer.rows.length === ${6 * outers}`, `the contours of ${name}`);
    }
    await page.context().close();
}

/// Objects of an OBJ file, side by side: tetrahedra.
async function parts_have_colours(page: Page): Promise<void> {
    const one = (name: string, x: number, first: number) =>
        `o ${name}\nv ${x} 0 0\nv ${x + 4} 0 0\nv ${x} 4 0\nv ${x} 0 4\n` +
        [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map((face) => `f ${face.map((corner) => corner + first).join(" ")}\n`).join("");
    writeFileSync(at("two.obj"), one("left", 0, 1) + one("<right>", 10, 5));
    await drop(page, at("two.obj"));
    await until(page, "state.name === 'two.obj' && state.layer !== null", "the parts");
    equal(await ask(page, "[state.mesh.parts, [...state.layer.rows].filter((_, i) => i % 6 === 1)]"), [["left", "<right>"], [0, 1]], "parts of contours");
    await page.selectOption("#colour", "part");
    check((await pixels(page, "#layer")).size > 6, "colours of parts");
}

async function open_meshes_say_so(browser: Browser): Promise<void> {
    const page = await open_page(browser);
    await drop(page, boxes("open.stl", [[0, 0, 0, 10, 10, 10]], 1));
    await hash_of(page);
    await page.waitForFunction(() => document.getElementById("notice")!.textContent!.startsWith("The mesh is open: 49 of 50 layers"));
    await page.click("#to-open");
    await until(page, "state.layer.index === state.index && state.layer.rows.some((value, i) => i % 6 === 0 && value === 3)", "an open contour");
    check((await page.textContent("#area"))!.startsWith("area not known"), "an area of an open layer");
    await until(page, "state.checked !== null", "the faults");
    await page.click("#tab-faults");
    await page.waitForFunction(() => /boundary edges\s*3/.test(document.getElementById("panel")!.textContent!));
    await page.waitForTimeout(300);
    check((await pixels(page, "#stack")).has(0xff6a00d4), "marks of faults in 3D");
    await page.context().close();
}

async function nothing_harms_it(browser: Browser): Promise<void> {
    const page = await open_page(browser);
    await drop(page, bone());
    const hash = await hash_of(page);
    const stl = readFileSync(bone());
    const bad: [string, Buffer, RegExp][] = [
        ["words.stl", Buffer.from("not a mesh at all\n"), /words\.stl/], ["empty.obj", Buffer.alloc(0), /empty\.obj/],
        ["short.stl", stl.subarray(0, 5000), /short\.stl/], ["zip.3mf", Buffer.from("PK\x03\x04 and nothing"), /zip\.3mf/],
        ["claims.stl", Buffer.concat([stl.subarray(0, 80), Buffer.from([255, 255, 255, 255]), stl.subarray(84)]), /claims\.stl/],
        ["nan.stl", Buffer.concat([stl.subarray(0, 96), Buffer.from([0, 0, 192, 127]), stl.subarray(100)]), /nan\.stl.*triangle/],
        ["deep.ply", Buffer.from("ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n"), /deep\.ply/],
    ];
    for (const [name, bytes, says] of bad) {
        writeFileSync(at(name), bytes);
        await page.evaluate(() => document.getElementById("notice")!.replaceChildren());
        await drop(page, at(name));
        await page.waitForSelector("#notice.error");
        const said = (await page.textContent("#notice"))!;
        check(says.test(said) && !said.includes("\n") && !said.includes("/mesh/"), `what is said of ${name}`, said);
        await page.keyboard.press("Escape");
        await until(page, "state.error === ''", "the end of the error");
        equal(await ask(page, "[state.name, state.hash]"), ["bone.stl", hash], `the mesh after ${name}`);
        equal(await page.locator("#sources option").allTextContents(), ["bone.stl"], `the list of meshes after ${name}`);
    }
    await ask(page, "void client.ask({ask: 'open', generation: 99, file: null, name: 'x', unit: 0})"); // no blob: the worker dies
    const begin = Date.now();
    await until(page, "state.notice.includes('started again')", "the notice");
    await until(page, `state.hash === '${hash}' && state.layer !== null`, "the mesh after the worker's death");
    console.log(`a dead worker and its mesh are back after ${Date.now() - begin} ms`);
    const name = "=<img src=x onerror=alert(1)>'&.stl";
    copyFileSync(bone(), at(name));
    await drop(page, at(name));
    await until(page, `state.name.startsWith('=<img')`, "the name");
    await hash_of(page);
    equal(await page.locator("#sources option").allTextContents(), [name], "the name as text");
    equal(await page.locator("img").count(), 0, "images");
    for (const value of ["", "-1", "1e-9", "1e999"]) {
        await page.fill("#height", value).catch(() => {});
        await page.waitForTimeout(200);
    }
    await page.keyboard.press("Escape");
    check((await ask<number>(page, "state.slabs.length")) > 0, "layers after heights that cannot be");
    await page.context().close();
}

async function links_are_views(browser: Browser): Promise<void> {
    tool("view", "bone.stl", at("plate.stl"), "-o", "page.html");
    const page = await open_page(browser, at("page.html"), "light", "#z=12.4&h=0.5&s=NaN&rule=99&__proto__=1");
    equal(await hash_of(page), hash_in(tool("slice", "bone.stl", "--layer-height", "0.5", "--fill-rule", "outermost", "--hash")), "hash by a link");
    check(Math.abs((await ask<number>(page, "state.slabs[2 * state.index]")) - 12.2) < 0.5, "height by a link");
    equal(await page.locator("#sources option").allTextContents(), ["bone.stl", "plate.stl"], "meshes of the page");
    equal(await ask(page, "[state.mesh.warnings, state.notice]"), [[], ""], "warnings of a mesh in the page");
    await page.selectOption("#sources", "1");
    await until(page, "state.name === 'plate.stl' && state.hash !== ''", "the other mesh");
    await page.evaluate(() => (location.hash = "#z=NaN"));
    await page.waitForTimeout(100);
    await page.context().close();
}

/// The colours of a part of the screen, as ABGR: a blank canvas has one.
async function pixels(page: Page, selector: string): Promise<Set<number>> {
    const picture = (await page.locator(selector).screenshot()).toString("base64");
    return new Set(await page.evaluate(async (data) => {
        const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))]));
        const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d")!;
        context.drawImage(bitmap, 0, 0);
        return [...new Set(new Uint32Array(context.getImageData(0, 0, bitmap.width, bitmap.height).data.buffer))];
    }, picture));
}

async function pictures(browser: Browser): Promise<void> {
    for (const scheme of ["light", "dark"] as const) {
        const page = await open_page(browser, page_path, scheme);
        await page.locator("#file").setInputFiles(make("bone", 400_000, "large.stl"));
        await hash_of(page);
        await until(page, "state.triangles !== null && state.islands_upto === state.slabs.length / 2", "the views", 60_000);
        await page.click("[data-tab=mesh]");
        await page.waitForFunction(() => /3D view\s*reduced to [\d,]+ triangles/.test(document.getElementById("panel")!.textContent!));
        await page.click("[data-tab=layer]");
        await ask(page, "void go(60)");
        await page.waitForSelector('body[data-layer="60"]');
        await page.check("#overhang");
        await until(page, "state.below !== null && state.below.seq === state.layer.seq && state.below.ends.length > 0", "the overhang");
        await page.waitForTimeout(300);
        for (const [canvas, least] of [["#layer", 20], ["#curve", 4], ["#stack", 100]] as const) {
            const found = (await pixels(page, canvas)).size;
            check(found >= least, `colours of ${canvas}`, found);
        }
        await page.screenshot({ path: at(`view-${scheme}.png`) });
        await page.context().close();
    }
    process.argv[5] !== undefined && copyFileSync(at("view-light.png"), process.argv[5]);
}

const browser = await launch();
try {
    for (const test of [numbers_are_the_tools, moves_are_followed, islands_and_overhang_are_found, other_files_open, open_meshes_say_so, nothing_harms_it, links_are_views, pictures]) {
        await test(browser);
        equal(wrong, [], `what went wrong in ${test.name}`);
        console.log(test.name.replaceAll("_", " "));
    }
    console.log(`${checked()} checks`);
} finally {
    await browser.close();
}
