//! The list of rooms in ARCHITECTURE.md, and what in the house is not as it says.

use crate::house::{House, below, circles};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// Lines that a room may have without its tests, unless its line in the list says otherwise.
const ROOM_LINES: usize = 1500;

/// One line of the list.
#[derive(Debug)]
pub struct Room {
    pub name: String,
    pub uses: BTreeSet<String>,
    pub most_lines: usize,
}

/// Reads the fenced block `rooms` of a page: `room: used room, used room`, or `room (2000 lines): used room`.
pub fn list(page: &str) -> Result<Vec<Room>, String> {
    let mut lines = page.lines().map(str::trim).skip_while(|line| *line != "```rooms");
    lines.next().ok_or("there is no block ```rooms")?;
    lines
        .take_while(|line| *line != "```")
        .filter(|line| !line.is_empty())
        .map(room)
        .collect()
}

fn room(line: &str) -> Result<Room, String> {
    let wrong = || format!("`{line}` is not of the form `room: used room, used room`");
    let (head, uses) = line.split_once(':').ok_or_else(wrong)?;
    let (name, most_lines) = match head.split_once('(') {
        Some((name, size)) => {
            let size = size.trim().strip_suffix("lines)").ok_or_else(wrong)?;
            (name, size.trim().parse().map_err(|_| wrong())?)
        }
        None => (head, ROOM_LINES),
    };
    let uses = uses.split(',').map(str::trim).filter(|name| !name.is_empty());
    Ok(Room {
        name: name.trim().to_owned(),
        uses: uses.map(str::to_owned).collect(),
        most_lines,
    })
}

/// Everything in which list and house differ, a line each.
pub fn problems(list: &[Room], house: &House) -> Vec<String> {
    let mut problems = problems_of_list(list);
    let room_of = |place: &str| {
        let above = list.iter().enumerate().filter(|(_, room)| below(place, &room.name));
        above.max_by_key(|(_, room)| room.name.len()).map(|(number, _)| number)
    };
    let rooms: Vec<Option<usize>> = house
        .files
        .iter()
        .map(|file| room_of(&file.place).filter(|_| !file.source.only_declares()))
        .collect();
    for (file, room) in house.files.iter().zip(&rooms) {
        if room.is_none() && !file.source.only_declares() {
            problems.push(format!("{} is in no room of the list", file.path));
        }
    }

    let files = &house.files;
    let uses = house.uses();
    let mut used: BTreeMap<(usize, usize), String> = BTreeMap::new();
    for one in &uses {
        if let (Some(from), Some(to)) = (rooms[one.from], rooms[one.to])
            && from != to
        {
            let text = format!("{} uses {} by {}", files[one.from].path, files[one.to].path, one.text);
            used.entry((from, to)).or_insert(text);
        }
    }
    for (&(from, to), text) in &used {
        if !list[from].uses.contains(&list[to].name) {
            problems.push(format!("{} may not use {}: {text}", list[from].name, list[to].name));
        }
    }
    for (from, room) in list.iter().enumerate() {
        for to in (0..list.len()).filter(|&to| room.uses.contains(&list[to].name)) {
            if !used.contains_key(&(from, to)) {
                problems.push(format!("{} doesn't use {}: strike it", room.name, list[to].name));
            }
        }
    }
    // What uses the type would call upwards, and no import would show it.
    for one in house.extensions() {
        if rooms[one.from] != rooms[one.to] {
            let (from, to) = (&files[one.from].path, &files[one.to].path);
            problems.push(format!(
                "{from} gives methods to a type of {to}, another room: {}",
                one.text
            ));
        }
    }
    problems.extend(sizes(house, &rooms, list));
    for circle in circles(files.len(), &uses) {
        let mut lines = BTreeMap::new();
        for one in &uses {
            if circle.contains(&one.from) && circle.contains(&one.to) {
                lines.entry((one.from, one.to)).or_insert(&one.text);
            }
        }
        let mut text = String::from("files import each other in a circle:");
        for ((from, to), import) in lines {
            let _ = write!(text, "\n    {} uses {} by {import}", files[from].path, files[to].path);
        }
        problems.push(text);
    }
    problems
}

/// The list stands from what uses nothing up: a room uses only rooms above its own line. So it has no circle.
fn problems_of_list(list: &[Room]) -> Vec<String> {
    let mut problems = Vec::new();
    let mut above: BTreeSet<&str> = BTreeSet::new();
    for room in list {
        for used in &room.uses {
            if !list.iter().any(|other| other.name == *used) {
                problems.push(format!("{} uses {used}, which is not in the list", room.name));
            } else if !above.contains(used.as_str()) {
                problems.push(format!(
                    "{} uses {used}, which doesn't stand above it in the list",
                    room.name
                ));
            }
        }
        if !above.insert(&room.name) {
            problems.push(format!("{} is in the list twice", room.name));
        }
    }
    problems
}

/// Rooms that are too large or empty; prints the size of each.
fn sizes(house: &House, rooms: &[Option<usize>], list: &[Room]) -> Vec<String> {
    let mut problems = Vec::new();
    let mut sizes: Vec<(usize, &str)> = Vec::new();
    for (number, room) in list.iter().enumerate() {
        let files = house.files.iter().zip(rooms).filter(|(_, room)| **room == Some(number));
        let lines: usize = files.map(|(file, _)| file.source.lines).sum();
        if lines == 0 {
            problems.push(format!("{} has no file", room.name));
        }
        if lines > room.most_lines {
            let most = room.most_lines;
            problems.push(format!(
                "{} has {lines} lines without its tests: at most {most}",
                room.name
            ));
        }
        sizes.push((lines, &room.name));
    }
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    for (lines, name) in sizes {
        println!("{lines:6} lines in {name}");
    }
    if let Some(file) = house.files.iter().max_by_key(|file| file.source.lines) {
        println!("{:6} lines in {}, the largest file", file.source.lines, file.path);
    }
    problems
}
