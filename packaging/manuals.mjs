// Makes manual pages, bash completions and the list of the server's settings of what the programs themselves print:
// manuals.mjs BIN OUT VERSION DATE. Nothing in them is
// written by hand, so none of them can be older than the program.
import { execFileSync } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';

const [bin, out, version, date] = process.argv.slice(2);
const files = {
  'enamel-server': ['/etc/enamel/server.toml', '/etc/enamel/server.env', '/var/lib/enamel'],
  'enamel-station': ['/etc/enamel/station.toml', '/var/lib/enamel-station'],
  'enamel-lab': ['/etc/enamel/station.toml'],
};

// What a command's help says: { about, usage, positionals, options, subcommands, more }. An entry is [what, text].
function readHelp(words) {
  const env = { PATH: '/usr/bin:/bin', HOME: '~' };  // defaults that name a home folder name everybody's
  const text = execFileSync(join(bin, words[0]), [...words.slice(1), '--help'], { encoding: 'utf8', env }).replaceAll(`${bin}/`, '');
  const help = { about: [], usage: '', positionals: [], options: [], subcommands: [], more: [] };
  let into = 'about';
  for (const line of text.split('\n')) {
    // Options of a section of the settings file come under its name: "budgets:".
    const part =
      { 'Positionals:': 'positionals', 'Options:': 'options', 'Subcommands:': 'subcommands' }[line] ??
      (/^[a-z]+:$/.test(line) ? 'options' : undefined);
    if (line.startsWith('Usage: ')) {
      help.usage = line.slice(7);
    } else if (part) {
      into = part;
    } else if (Array.isArray(help[into]) && into !== 'about' && into !== 'more') {
      if (line === '') {
        into = 'more';
      } else if (/^ {2}\S/.test(line)) {
        const [, what, rest] = line.match(/^ {2}(\S.*?)(?: {2,}(.*)|$)/);
        // An option that reaches into the column of texts has no two spaces before its own.
        help[into].push([what, rest ?? '']);
      } else {
        const last = help[into].at(-1);
        last[1] = `${last[1]} ${line.trim()}`.trim();
      }
    } else {
      help[into].push(line);
    }
  }
  help.about = help.about.join(' ').trim();
  help.more = help.more.join('\n').trim();
  return help;
}

// A long list of choices has no blanks: it may be broken after each comma.
const escaped = (text) => text.replace(/\\/g, '\\e').replace(/-/g, '\\-').replace(/^([.'])/gm, '\\&$1').replace(/,(?=\S)/g, ',\\:');
const entries = (list) => list.map(([what, text]) => `.TP\n.B ${escaped(what)}\n${escaped(text) || '\\&'}\n`).join('');
const verbatim = (text) => (text ? `.PP\n.nf\n${escaped(text)}\n.fi\n` : '');

const namesOf = (what) => what.split(/[ {]/)[0].match(/--?[a-z][a-z0-9-]*/g) ?? [];
const choicesOf = (what) => what.match(/\{([^}]*)\}/)?.[1].split(',');
const takesValue = /^\S+ (?!REQUIRED|Needs:|Excludes:)[A-Z]/;
// What is built in, as the station lists it: names for options that take another's too, or a file.
const listed = (command) => execFileSync(join(bin, 'enamel-station'), [command], { encoding: 'utf8' });
const profiles = listed('profiles').match(/^\S+/gm), scenes = listed('scenes').match(/^builtin:\S+/gm);
const exercises = listed('scenes').match(/(?<=^  )\S+/gm);
const builtIn = { '--profile': profiles, '--scene': scenes, '--exercise': exercises };

mkdirSync(out, { recursive: true });
for (const program of Object.keys(files)) {
  const words = new Map();  // "admin put-profile" -> what may follow it
  const values = [];  // ["admin add-person --role", what may follow it: nothing, if that has no names]
  let commands = '';
  const walk = (path, depth) => {
    const help = readHelp([program, ...path]);
    words.set(path.join(' '), [...help.subcommands.map(([name]) => name), ...help.options.flatMap(([what]) => namesOf(what)), ...help.positionals.flatMap(([what]) => choicesOf(what) ?? [])]);
    for (const [what] of help.options.filter(([what]) => takesValue.test(what))) {
      const list = choicesOf(what) ?? builtIn[namesOf(what)[0]] ?? [];
      for (const name of namesOf(what)) values.push([`${path.join(' ')} ${name}`, list]);
    }
    if (depth > 0) {
      commands += `.SS ${escaped(path.join(' '))}\n${escaped(help.about)}\n`;
      commands += `.PP\n${escaped(help.usage)}\n${entries(help.positionals)}${entries(help.options.filter(([what]) => !what.startsWith('-h,')))}`;
      commands += verbatim(help.more);
    }
    for (const [name] of help.subcommands) walk([...path, name], depth + 1);
    return help;
  };
  const help = walk([], 0);
  if (program === 'enamel-server') {
    const all = execFileSync(join(bin, program), ['serve', '--data', '/var/lib/enamel', '--print-settings'], { encoding: 'utf8', env: {} });
    writeFileSync(join(out, 'all_settings.toml'), all);
  }
  const page = `.TH ${program.toUpperCase()} 1 "${date}" "Enamel ${version}"
.ad l
.SH NAME
${program} \\- ${escaped(help.about.replace(/^[Ee]namel[- ]\w+: /, ''))}
.SH SYNOPSIS
.B ${program}
[\\fIOPTIONS\\fR] \\fICOMMAND\\fR [\\fIOPTIONS\\fR]
.SH OPTIONS
${entries(help.options)}.SH COMMANDS
${entries(help.subcommands)}${verbatim(help.more)}.SH EVERY COMMAND
${commands}.SH FILES
${files[program].map((file) => `.I ${escaped(file)}\n.br\n`).join('')}.SH SEE ALSO
/usr/share/doc/enamel/docs/README.md, of the package enamel\\-doc
`;
  writeFileSync(join(out, `${program}.1.gz`), gzipSync(page, { level: 9 }));
  const table = [...words].map(([path, next]) => `    '${path}') words='${next.join(' ')}' ;;`).join('\n');
  const after = values.map(([option, list]) => `    '${option}') words='${list.join(' ')}' ;;`).join('\n');
  const name = `_${program.replace('-', '_')}`;
  writeFileSync(join(out, `${program}.bash`), `# Made of ${program} --help.
${name}() {
  local path= words= word
  for word in "\${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    case $word in
      -*) break ;;
    esac
    case " ${[...words.keys()].filter(Boolean).map((path) => path.replace(/ /g, '/')).join(' ')} " in
      *" \${path:+$path/}$word "*) path=\${path:+$path/}$word ;;
      *) break ;;
    esac
  done
  case \${path//\\// } in
${table}
  esac
  case "\${path//\\// } \${COMP_WORDS[COMP_CWORD-1]}" in
${after}
  esac
  COMPREPLY=($(compgen -W "$words" -- "\${COMP_WORDS[COMP_CWORD]}"))
}
complete -o default -F ${name} ${program}
`);
}
