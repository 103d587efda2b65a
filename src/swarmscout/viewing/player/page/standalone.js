// Starts the page out of one file: every module lies in it, zipped, after those that it imports.
(async () => {
  const urls = {};
  for (const script of document.querySelectorAll('script[type="application/x-code"]')) {
    const letters = atob(script.textContent);
    const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    let code = await new Response(stream).text();
    for (const [specifier, file] of Object.entries(JSON.parse(script.dataset.imports))) {
      const quoted = specifier.replace(/[.*+?^${}()|[\]\\/]/g, "\\$&");
      code = code.replace(new RegExp(`(from\\s*)(["'])${quoted}\\2`, "g"), `$1"${urls[file]}"`);
    }
    const url = URL.createObjectURL(new Blob([code], { type: "text/javascript" }));
    urls[script.dataset.file] = url;
    script.remove();
    if (script.dataset.kind === "plain") {
      await new Promise((done, fail) => {
        const plain = Object.assign(document.createElement("script"), { src: url, onload: done, onerror: fail });
        document.head.append(plain);
      });
    }
  }
  await import(urls["main.js"]);
})().catch((error) => {
  const sorry = document.getElementById("sorry");
  sorry.hidden = false;
  if (!sorry.textContent) sorry.textContent = `This page needs a newer browser: ${error.message}`;
  throw error;
});
